#pragma once
/// Limits of the freed memory that the allocator holds back, and a cache of blocks for one thread.

#include <array>
#include <cstddef>

namespace sightline {

/// Large requests run on many threads. For each of up to eight heaps per core, glibc would hold
/// back the most that the heap ever needed: 400 MiB after 150 answers of 5 MB. To be called before
/// any thread is made.
void bound_heaps();

/// While it lives, its thread caches at most 3 MiB of the blocks that it frees, for its next
/// allocations. For blocks of more than 1 KiB, and for many at once, glibc takes the lock of a heap
/// that threads share. A thread that lost its processor, or returns memory, holds the lock for
/// milliseconds.
class KeptBlocks {
 public:
  KeptBlocks();
  ~KeptBlocks();
  KeptBlocks(const KeptBlocks&) = delete;
  KeptBlocks& operator=(const KeptBlocks&) = delete;

  /// Null where no block of that size is cached.
  void* take(std::size_t size) noexcept;
  /// Bytes to allocate for `size` bytes, so that the block can be cached later.
  static std::size_t rounded(std::size_t size) noexcept;
  /// False where it is not cached: it goes back to the heap.
  bool keep(void* block) noexcept;

 private:
  struct Block {
    Block* next;
  };
  struct Shelf {
    Block* first = nullptr;
    std::size_t count = 0;
  };
  static constexpr std::size_t kLeast = 5, kMost = 17;  ///< powers of two, in bytes
  std::array<Shelf, kMost - kLeast + 1> shelves_;       ///< blocks of at least 2^(kLeast + i)
};

}  // namespace sightline
