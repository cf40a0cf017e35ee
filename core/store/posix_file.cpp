#include "core/store/posix_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace sightline {
namespace {

/// From the beginning, until `bytes` are filled or the file ends. How many there were.
Result<std::size_t> read_some(const FileDescriptor& file, std::span<std::byte> bytes,
                              const char* doing) {
  std::size_t size = 0;
  while (size < bytes.size()) {
    const ssize_t got =
        ::pread(file.number(), bytes.data() + size, bytes.size() - size, static_cast<off_t>(size));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return io_error(doing, errno);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  return size;
}

}  // namespace

Error io_error(const char* doing, int number) {
  Error error{ErrorKind::kInternal, "STORE_IO",
              std::string("cannot ") + doing + ": " + std::generic_category().message(number), ""};
  switch (number) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      error.kind = ErrorKind::kOutOfSpace;
      error.code = "STORE_FULL";
      break;
    case EMFILE:
    case ENFILE:
      error.kind = ErrorKind::kBusy;
      error.code = "STORE_BUSY";
      break;
    case ENOMEM:
      error.kind = ErrorKind::kOutOfSpace;
      error.code = "MEMORY_FULL";
      break;
  }
  return error;
}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    close();
    number_ = std::exchange(other.number_, -1);
  }
  return *this;
}

void FileDescriptor::close() {
  if (number_ >= 0) ::close(number_);
  number_ = -1;
}

Result<FileDescriptor> open_file(const std::filesystem::path& file, int flags, const char* doing) {
  const int number = ::open(file.c_str(), flags | O_CLOEXEC, 0640);
  if (number < 0) return io_error(doing, errno);
  return FileDescriptor(number);
}

Status write_all(const FileDescriptor& file, std::span<const std::byte> bytes, const char* doing) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.number(), bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return io_error(doing, errno);
    }
    if (written == 0) return io_error(doing, ENOSPC);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return success();
}

Status sync_file(const FileDescriptor& file, const char* doing) {
  if (::fsync(file.number()) != 0) return io_error(doing, errno);
  return success();
}

Status sync_folder(const std::filesystem::path& folder, const char* doing) {
  auto opened = open_file(folder, O_RDONLY | O_DIRECTORY, doing);
  if (!opened) return opened.error();
  return sync_file(*opened, doing);
}

Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                   const char* doing) {
  if (::rename(from.c_str(), to.c_str()) != 0) return io_error(doing, errno);
  return success();
}

Result<std::vector<std::filesystem::path>> list_folder(const std::filesystem::path& folder,
                                                       const char* doing) {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    paths.push_back(at->path());
  }
  if (error) return io_error(doing, error.value());
  return paths;
}

Result<std::string> read_small_file(const std::filesystem::path& file, std::size_t limit,
                                    const char* doing) {
  auto opened = open_file(file, O_RDONLY, doing);
  if (!opened) return std::move(opened).error();
  std::string text(limit + 1, '\0');
  const auto size = read_some(*opened, std::as_writable_bytes(std::span(text)), doing);
  if (!size) return size.error();
  if (*size > limit) {
    return Error{ErrorKind::kInternal, "STORE_DAMAGED",
                 std::string("cannot ") + doing + ": it is longer than any", ""};
  }
  text.resize(*size);
  return text;
}

Result<MappedFile> MappedFile::map(const FileDescriptor& file, const char* doing) {
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return io_error(doing, errno);
  MappedFile mapped;
  mapped.size_ = static_cast<std::size_t>(status.st_size);
  if (mapped.size_ < kMappedFrom) {
    mapped.read_.resize(mapped.size_);
    const auto size = read_some(file, mapped.read_, doing);
    if (!size) return size.error();
    mapped.size_ = *size;
    return mapped;
  }
  void* data = ::mmap(nullptr, mapped.size_, PROT_READ, MAP_PRIVATE, file.number(), 0);
  if (data == MAP_FAILED) {
    return io_error(doing, errno);
  }
  mapped.mapped_ = static_cast<const std::byte*>(data);
  return mapped;
}

MappedFile::~MappedFile() {
  if (mapped_ != nullptr) ::munmap(const_cast<std::byte*>(mapped_), size_);
}

}  // namespace sightline
