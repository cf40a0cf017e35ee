#include "core/import/input/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// Closes the descriptor at the end of the scope; the mapping outlives it.
struct Descriptor {
  int number = -1;
  explicit Descriptor(int n) : number(n) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

Error unreadable(const std::string& name, const char* why) {
  return {ErrorKind::kNotFound, "GLTF_FILE_UNREADABLE", name + ": " + why, ""};
}

}  // namespace

Result<MappedFile> MappedFile::open(const std::filesystem::path& path, std::uint64_t limit,
                                    const std::string& name) {
  // O_NONBLOCK: opening a pipe or a device must not wait; it is refused right after.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number < 0) return unreadable(name, "cannot be opened");
  struct stat status = {};
  if (::fstat(file.number, &status) != 0) return unreadable(name, "cannot be examined");
  if (!S_ISREG(status.st_mode)) return unreadable(name, "is not a regular file");
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > limit) return beyond_limit("FILE_BYTES", name + ": bytes", size, limit);
  if (size == 0) return MappedFile(nullptr, 0);  // an empty mapping is an error to mmap
  void* data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.number, 0);
  if (data == MAP_FAILED) return unreadable(name, "cannot be mapped");
  return MappedFile(static_cast<const std::byte*>(data), size);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

void MappedFile::read_sparsely() const {
  // A wish: where it is not granted, more is read and nothing else changes.
  if (data_ != nullptr) ::madvise(const_cast<std::byte*>(data_), size_, MADV_RANDOM);
}

void will_need(std::span<const std::byte> bytes) {
  // For one such call Linux reads at most 128 KiB in advance (by default), however long the range
  // is. A page or two come as fast when they are touched.
  constexpr std::size_t kWindow = 128 << 10;
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  if (bytes.size() <= 2 * page) return;
  // From the beginning of a page, as madvise wants it.
  const std::size_t before = reinterpret_cast<std::uintptr_t>(bytes.data()) % page;
  auto* const begin = const_cast<std::byte*>(bytes.data()) - before;
  const std::size_t size = bytes.size() + before;
  for (std::size_t at = 0; at < size; at += kWindow) {
    ::madvise(begin + at, std::min(kWindow, size - at), MADV_WILLNEED);
  }
}

void read_all(std::span<const std::byte> bytes) {
  will_need(bytes);
  unsigned sum = 0;
  for (const std::byte byte : bytes) sum += std::to_integer<unsigned>(byte);
  // Where nobody wants the sum, a compiler would leave out the reading.
  [[maybe_unused]] const volatile unsigned kept = sum;
}

}  // namespace sightline::gltf
