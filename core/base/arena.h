#pragma once
/// Arena: memory for data that is written once, front to back, and then only read. Trees are stored
/// in arenas.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

namespace sightline {

/// A reserved range of address space, which the destructor frees: reserve it, take() parts of it,
/// then shrink_to_fit(). The system adds memory when a page is first written. It uses huge pages
/// where it has them: without them, random walks through a tree take 5-7% longer. One thread may
/// write; then any number may read.
class Arena {
 public:
  /// Every allocation starts at a multiple of 32 bytes, half a cache line.
  static constexpr std::size_t kGranule = 32;

  Arena() = default;  ///< has no capacity
  /// Reserves `capacity` bytes of address space, none of it touched. Throws std::bad_alloc.
  explicit Arena(std::size_t capacity);
  /// Refers to `used` bytes at `data`, which stay valid while `owner` lives: a file in memory, or
  /// another arena. `owner` is not null. Nothing may be written, and only at() const and used() may
  /// be called.
  Arena(const std::byte* data, std::size_t used, std::shared_ptr<const void> owner);
  Arena(Arena&& other) noexcept { swap(other); }
  Arena& operator=(Arena&& other) noexcept {
    swap(other);
    return *this;
  }
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;
  ~Arena();

  /// Allocates the next `bytes`, rounded up to whole granules and zero-filled. Returns the index of
  /// their first granule, for at(). Precondition: they fit into the capacity.
  std::uint32_t take(std::size_t bytes);
  /// Returns the pages behind the allocated ones to the system; take() must not follow.
  void shrink_to_fit();

  /// The address of a granule; valid while the memory lives. Moving the arena does not move it.
  std::byte* at(std::uint32_t granule) { return data_ + std::size_t{granule} * kGranule; }
  const std::byte* at(std::uint32_t granule) const {
    return data_ + std::size_t{granule} * kGranule;
  }
  /// Bytes allocated so far, whole granules.
  std::size_t used() const { return used_; }

 private:
  void swap(Arena& other) {
    std::swap(data_, other.data_);
    std::swap(used_, other.used_);
    std::swap(capacity_, other.capacity_);
    std::swap(owner_, other.owner_);
  }
  std::byte* data_ = nullptr;
  std::size_t used_ = 0;
  std::size_t capacity_ = 0;
  /// owner of the memory if the arena only refers to it; else null
  std::shared_ptr<const void> owner_;
};

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
