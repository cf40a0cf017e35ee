#include "core/base/overflow_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/pages.h"
#include "core/base/unlinked_file.h"

namespace sightline {
namespace {

/// Unmapped by one system call, for which all processors stop. In calls of 1 MiB, frames beyond the
/// budget take up to twice as long.
constexpr std::size_t kCell = 16 << 20;
/// A file that small pieces share.
constexpr std::size_t kSharedFile = 64 << 20;
constexpr std::chrono::milliseconds kOften{2}, kSeldom{20};

/// Bytes of all files that the process maps, in memory or not: its program and libraries.
std::uint64_t file_mappings() {
  std::ifstream maps("/proc/self/maps");
  std::uint64_t sum = 0;
  for (std::string line; std::getline(maps, line);) {
    unsigned long long begin = 0, end = 0, inode = 0;
    if (std::sscanf(line.c_str(), "%llx-%llx %*s %*s %*s %llu", &begin, &end, &inode) == 3 &&
        inode != 0)
      sum += end - begin;
  }
  return sum;
}

}  // namespace

struct OverflowMemory::File {
  explicit File(std::shared_ptr<OverflowMemory> memory) : owner(std::move(memory)) {}
  ~File() {
    if (begin != nullptr) owner->unmap(begin);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const std::shared_ptr<OverflowMemory> owner;
  std::byte* begin = nullptr;
};

std::shared_ptr<OverflowMemory> OverflowMemory::make(std::string folder, std::uint64_t file_bytes) {
  return std::shared_ptr<OverflowMemory>(new OverflowMemory(std::move(folder), file_bytes));
}

OverflowMemory::OverflowMemory(std::string folder, std::uint64_t file_bytes)
    : folder_(std::move(folder)),
      file_bytes_(file_bytes),
      statm_(::open("/proc/self/statm", O_RDONLY | O_CLOEXEC)),
      other_most_(file_mappings()) {
  other_bytes_ = mapped_bytes();
}

OverflowMemory::~OverflowMemory() {
  {
    const std::lock_guard hold(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (statm_ >= 0) ::close(statm_);
}

std::uint64_t OverflowMemory::mapped_bytes() const {
  std::array<char, 128> text{};
  const ssize_t count = statm_ < 0 ? -1 : ::pread(statm_, text.data(), text.size() - 1, 0);
  unsigned long long size = 0, resident = 0, shared = 0;
  if (count <= 0 || std::sscanf(text.data(), "%llu %llu %llu", &size, &resident, &shared) != 3) {
    return 0;
  }
  return shared * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Precondition: mutex_ is held.
std::shared_ptr<OverflowMemory::File> OverflowMemory::map_file(std::size_t bytes) {
  const std::size_t size = whole_pages(bytes);
  if (size < bytes || size > left()) return {};
  auto mapped = std::make_shared<File>(shared_from_this());
  regions_.reserve(regions_.size() + 1);
  const int file = make_unlinked_file(folder_);
  if (file < 0) return {};
  // A page that the disk has no room for would be a signal later.
  const bool has_room = ::posix_fallocate(file, 0, static_cast<off_t>(size)) == 0;
  void* const memory =
      has_room ? ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
  ::close(file);
  if (memory == MAP_FAILED) return {};
  mapped->begin = static_cast<std::byte*>(memory);
  regions_.push_back({mapped->begin, size, size});
  used_ += size;
  return mapped;
}

std::uint64_t OverflowMemory::left() const {
  return file_bytes_ - std::min<std::uint64_t>(file_bytes_, used_);
}

/// Precondition for these: mutex_ is held.
OverflowMemory::Region* OverflowMemory::region_of(const void* at) {
  const auto* const byte = static_cast<const std::byte*>(at);
  const auto found = std::find_if(regions_.begin(), regions_.end(), [&](const Region& region) {
    return !std::less<>()(byte, region.begin) && std::less<>()(byte, region.begin + region.size);
  });
  return found == regions_.end() ? nullptr : &*found;
}

void OverflowMemory::unmap(std::byte* begin) {
  const std::lock_guard hold(mutex_);
  Region* const region = region_of(begin);
  ::munmap(region->begin, region->size);
  used_ -= region->counted;
  *region = regions_.back();
  regions_.pop_back();
}

void OverflowMemory::give_back(std::byte* begin, std::size_t bytes) {
  const std::lock_guard hold(mutex_);
  Region* const region = region_of(begin);
  if (region == nullptr || ::madvise(begin, bytes, MADV_REMOVE) != 0) return;
  region->counted -= bytes;
  used_ -= bytes;
}

std::shared_ptr<std::byte> OverflowMemory::take(std::size_t bytes) {
  constexpr std::size_t kAlignment = 64;
  std::shared_ptr<File> file;  // released after the lock
  const std::lock_guard hold(mutex_);
  if (!thread_.joinable()) {
    try {
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error&) {
      return {};
    }
  }
  if (bytes > kSharedFile / 4) {
    file = map_file(bytes);
    return file ? std::shared_ptr<std::byte>(file, file->begin) : nullptr;
  }
  // A piece that has whole pages has no other piece in them: give_back() must not touch the next.
  const bool is_small = bytes < whole_pages(1);
  const std::size_t size =
      is_small ? (bytes + kAlignment - 1) / kAlignment * kAlignment : whole_pages(bytes);
  file = shared_file_.lock();
  if (!is_small) shared_used_ = whole_pages(shared_used_);
  if (file == nullptr || shared_used_ + size > shared_size_) {
    const std::size_t most =
        std::max<std::size_t>(size, std::min<std::uint64_t>(kSharedFile, left()));
    file = map_file(most);
    if (file == nullptr) return {};
    shared_file_ = file;
    shared_size_ = most;
    shared_used_ = 0;
  }
  std::byte* const begin = file->begin + shared_used_;
  shared_used_ += size;
  return {std::move(file), begin};
}

void OverflowMemory::map_pages(const std::byte* begin, std::size_t bytes) {
  const volatile std::byte* const page = begin;
  const std::size_t step = whole_pages(1);
  for (std::size_t at = 0; at < bytes; at += step) static_cast<void>(page[at]);
}

void OverflowMemory::unmap_pages(const std::byte* begin, std::size_t bytes) {
  // The file has what was written.
  ::madvise(const_cast<std::byte*>(begin), bytes, MADV_DONTNEED);
}

bool OverflowMemory::contains(const void* at) const {
  const std::lock_guard hold(mutex_);
  return const_cast<OverflowMemory*>(this)->region_of(at) != nullptr;
}

void OverflowMemory::run() {
  std::uint64_t before = 0;
  std::unique_lock hold(mutex_);
  while (!stopping_) {
    const std::uint64_t limit = resident_limit_, all = mapped_bytes();
    other_bytes_ = std::min(other_bytes_, all);
    const std::uint64_t resident = all - std::min(all, other_bytes_);
    // Some more, so that the next page does not begin it again.
    if (resident > limit) {
      hold.unlock();
      evict(resident - limit + limit / 16);
      hold.lock();
    }
    // While nobody reads, nothing is mapped.
    const bool is_read = resident > limit / 2 && resident != std::exchange(before, resident);
    changed_.wait_for(hold, is_read ? kOften : kSeldom, [this] { return stopping_; });
  }
}

void OverflowMemory::evict(std::uint64_t bytes) {
  // What is unmapped may not have been in memory: the mapped pages are counted again.
  const std::uint64_t before = mapped_bytes();
  for (std::uint64_t passed = 0; passed < used_;) {
    {
      const std::lock_guard hold(mutex_);
      if (hand_ >= regions_.size()) hand_ = 0;
      if (regions_.empty()) return;
      const Region& region = regions_[hand_];
      const std::size_t begin = std::min(hand_at_, region.size);
      const std::size_t size = std::min(kCell, region.size - begin);
      if (size > 0) unmap_pages(region.begin + begin, size);
      evicted_ += size;
      passed += std::max<std::size_t>(size, 1);
      hand_at_ = begin + size;
      if (hand_at_ >= region.size) {
        ++hand_;
        hand_at_ = 0;
      }
    }
    const std::uint64_t now = mapped_bytes();
    if (before - std::min(before, now) >= bytes) return;
  }
  // What is still mapped is the program's own, which has read more of its files.
  const std::lock_guard hold(mutex_);
  other_bytes_ = std::min(other_most_, mapped_bytes());
}

}  // namespace sightline
