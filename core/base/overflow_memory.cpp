#include "core/base/overflow_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <functional>
#include <system_error>
#include <utility>

#include "core/base/pages.h"

namespace sightline {
namespace {

/// Unmapped at once: long enough that a system call costs little for each page.
constexpr std::size_t kCell = 1 << 20;
/// A file that small pieces share.
constexpr std::size_t kSharedFile = 64 << 20;
constexpr std::chrono::milliseconds kOften{2}, kSeldom{20};

/// -1 with errno.
int make_file(const std::string& folder) {
  const int unnamed = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (unnamed >= 0 || (errno != EOPNOTSUPP && errno != EISDIR)) return unnamed;
  // Some file systems make no file without a name.
  std::string name = folder + "/sightline-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

/// Bytes of mapped files in the memory of this process; 0 where the system does not say.
std::uint64_t mapped_file_bytes() {
  std::FILE* const file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  unsigned long long size = 0, resident = 0, shared = 0;
  const int read = std::fscanf(file, "%llu %llu %llu", &size, &resident, &shared);
  std::fclose(file);
  return read == 3 ? shared * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace

std::shared_ptr<OverflowMemory> OverflowMemory::make(std::string folder, std::uint64_t file_bytes) {
  return std::shared_ptr<OverflowMemory>(new OverflowMemory(std::move(folder), file_bytes));
}

OverflowMemory::~OverflowMemory() {
  {
    const std::lock_guard hold(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

/// Precondition: mutex_ is held.
std::shared_ptr<std::byte> OverflowMemory::map_file(std::size_t bytes) {
  const std::size_t size = whole_pages(bytes);
  if (size < bytes || size > file_bytes_ - std::min<std::uint64_t>(file_bytes_, used_)) return {};
  regions_.reserve(regions_.size() + 1);
  const int file = make_file(folder_);
  if (file < 0) return {};
  // A page that the disk has no room for would be a signal later.
  const bool has_room = ::posix_fallocate(file, 0, static_cast<off_t>(size)) == 0;
  void* const memory =
      has_room ? ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
  ::close(file);
  if (memory == MAP_FAILED) return {};
  auto* const begin = static_cast<std::byte*>(memory);
  regions_.push_back({begin, size});
  used_ += size;
  return {begin, [self = weak_from_this().lock()](std::byte* at) { self->unmap(at); }};
}

void OverflowMemory::unmap(std::byte* begin) {
  const std::lock_guard hold(mutex_);
  const auto region = std::find_if(regions_.begin(), regions_.end(),
                                   [&](const Region& each) { return each.begin == begin; });
  ::munmap(region->begin, region->size);
  used_ -= region->size;
  *region = regions_.back();
  regions_.pop_back();
}

std::shared_ptr<std::byte> OverflowMemory::take(std::size_t bytes) {
  constexpr std::size_t kAlignment = 64;
  std::shared_ptr<std::byte> file;  // released after the lock
  const std::lock_guard hold(mutex_);
  if (!thread_.joinable()) {
    other_bytes_ = mapped_file_bytes();
    try {
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error&) {
      return {};
    }
  }
  if (bytes > kSharedFile / 4) return map_file(bytes);
  const std::size_t size = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  file = shared_file_.lock();
  if (file == nullptr || shared_used_ + size > kSharedFile) {
    auto next = map_file(kSharedFile);
    if (next == nullptr) return {};
    shared_file_ = next;
    shared_used_ = size;
    return {next, next.get()};
  }
  std::byte* const begin = file.get() + shared_used_;
  shared_used_ += size;
  return {std::move(file), begin};
}

bool OverflowMemory::contains(const void* at) const {
  const auto* const byte = static_cast<const std::byte*>(at);
  const std::lock_guard hold(mutex_);
  return std::any_of(regions_.begin(), regions_.end(), [&](const Region& region) {
    return !std::less<>()(byte, region.begin) && std::less<>()(byte, region.begin + region.size);
  });
}

void OverflowMemory::run() {
  std::uint64_t before = 0;
  std::unique_lock hold(mutex_);
  while (!stopping_) {
    const std::uint64_t limit = resident_limit_, all = mapped_file_bytes();
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
  constexpr std::size_t kCells = 16;
  const std::uint64_t before = mapped_file_bytes();
  for (std::uint64_t passed = 0; passed < used_; passed += kCells * kCell) {
    for (std::size_t i = 0; i < kCells; ++i) {
      const std::lock_guard hold(mutex_);
      if (hand_ >= regions_.size()) hand_ = 0;
      if (regions_.empty()) return;
      const Region& region = regions_[hand_];
      const std::size_t begin = std::min(hand_at_, region.size);
      const std::size_t size = std::min(kCell, region.size - begin);
      // The file has what was written; the pages are mapped again when they are read.
      if (size > 0) ::madvise(region.begin + begin, size, MADV_DONTNEED);
      evicted_ += size;
      hand_at_ = begin + size;
      if (hand_at_ < region.size) continue;
      ++hand_;
      hand_at_ = 0;
    }
    const std::uint64_t now = mapped_file_bytes();
    if (before - std::min(before, now) >= bytes) return;
  }
}

}  // namespace sightline
