#pragma once
/// How much freed memory the allocator may keep, and who waits for it.

#include <array>
#include <cstddef>

namespace sightline {

/// Large requests come on many threads, and glibc would keep for each of up to eight heaps per core
/// the most that one ever needed: 400 MiB after 150 answers of 5 MB. Before any thread is made.
void bound_heaps();

/// While it lives, its thread keeps some of the blocks that it frees, at most 3 MiB, for what it
/// asks for next. For blocks of more than a KiB, and for many at once, glibc takes the lock of a
/// heap that others share: one that lost its processor, or gives memory back, holds it for
/// milliseconds.
class KeptBlocks {
 public:
  KeptBlocks();
  ~KeptBlocks();
  KeptBlocks(const KeptBlocks&) = delete;
  KeptBlocks& operator=(const KeptBlocks&) = delete;

  /// Null where no block of that size is kept.
  void* take(std::size_t size) noexcept;
  /// What is to be asked of the heap for `size` bytes, so that the block can be kept later.
  static std::size_t rounded(std::size_t size) noexcept;
  /// False where it is not kept: it goes back to the heap.
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
