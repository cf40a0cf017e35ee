#pragma once
/// OverflowMemory: memory beyond a budget, in temporary files that the process maps. The process has
/// a part of it in its memory, near a limit; a read of the rest waits for the file.

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sightline {

/// Allocates memory in unlinked files of one folder, which should be on a disk. Its own thread
/// measures the mapped pages every few milliseconds, and unmaps pages beyond the limit, in the order
/// of their addresses (madvise). The system has them in its cache of files, or only on the disk. A
/// disk that cannot read its file ends the process by SIGBUS, as one that cannot read a page of swap.
/// Held by shared_ptr. Thread-safe.
class OverflowMemory : public std::enable_shared_from_this<OverflowMemory> {
 public:
  /// folder      where the files are made; they have no names there
  /// file_bytes  the most bytes of all files
  static std::shared_ptr<OverflowMemory> make(std::string folder, std::uint64_t file_bytes);
  /// Precondition: all that take() returned is released. Holders retain the object.
  ~OverflowMemory();
  OverflowMemory(const OverflowMemory&) = delete;
  OverflowMemory& operator=(const OverflowMemory&) = delete;

  /// Allocates `bytes` zeros at a multiple of 64 bytes; the last holder releases them. Returns null
  /// if the files have no room for them or the system has none. Pieces of a page or more begin at a
  /// page. Cost: allocates the blocks of the file. Throws std::bad_alloc.
  std::shared_ptr<std::byte> take(std::size_t bytes);
  /// Returns blocks of the disk, where the file system can: the bytes are zeros then. Precondition:
  /// whole pages of one piece, not given back before.
  void give_back(std::byte* begin, std::size_t bytes);
  /// Sets how many bytes should be in the memory of the process; at first none. Fast reads of cached
  /// files exceed it for milliseconds.
  void set_resident_limit(std::uint64_t bytes) { resident_limit_ = bytes; }
  std::uint64_t resident_limit() const { return resident_limit_; }
  /// Reads pages in the order of their addresses, so that they are in memory. That is up to three
  /// times as fast as MADV_WILLNEED (docs/decisions/0036).
  static void map_pages(const std::byte* begin, std::size_t bytes);
  /// Unmaps whole pages; they are mapped again when they are read. Precondition of both: the pages
  /// are of pieces that take() returned.
  static void unmap_pages(const std::byte* begin, std::size_t bytes);
  /// True if `at` lies in memory that take() returned.
  bool contains(const void* at) const;

  /// Bytes of all files now.
  std::uint64_t bytes() const { return used_; }
  /// Bytes that were unmapped to stay below the limit, in total; some were not in memory.
  std::uint64_t evicted_bytes() const { return evicted_; }

 private:
  struct File;  ///< unmaps it
  /// A mapping of a whole file.
  struct Region {
    std::byte* begin = nullptr;
    std::size_t size = 0;
    std::size_t counted = 0;  ///< size without what was given back
  };
  OverflowMemory(std::string folder, std::uint64_t file_bytes);
  std::shared_ptr<File> map_file(std::size_t bytes);
  void unmap(std::byte* begin);
  std::uint64_t left() const;
  Region* region_of(const void* at);
  /// Bytes of mapped files in the memory of this process; 0 where the system does not say.
  std::uint64_t mapped_bytes() const;
  void run();
  void evict(std::uint64_t bytes);

  const std::string folder_;
  const std::uint64_t file_bytes_;
  const int statm_;                 ///< descriptor
  const std::uint64_t other_most_;  ///< bytes of other mapped files: the program, its libraries
  std::atomic<std::uint64_t> used_{0}, resident_limit_{0}, evicted_{0};

  mutable std::mutex mutex_;  ///< protects the members below, and the mappings
  std::vector<Region> regions_;
  std::size_t hand_ = 0, hand_at_ = 0;  ///< the region, and the byte in it, that is evicted next
  std::weak_ptr<File> shared_file_;     ///< of several small pieces; a new one when it is full
  std::size_t shared_size_ = 0, shared_used_ = 0;
  std::uint64_t other_bytes_ = 0;  ///< of other_most_, those in the memory of the process
  std::condition_variable changed_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace sightline

// Tests: tests/unit/base/overflow_memory_test.cpp
