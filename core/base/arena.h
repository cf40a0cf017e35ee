#pragma once
/// Memory for things that are written once, front to back, and then only read: trees.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

namespace sightline {

/// A range of address space that is touched as far as it is used. Huge pages where the kernel has
/// them: random walks through a tree cost 5-7% more without.
class Arena {
 public:
  static constexpr std::size_t kGranule = 32;  ///< every allocation starts on half a cache line

  Arena() = default;
  /// Reserves `capacity` bytes of address space, none of it touched. Throws std::bad_alloc.
  explicit Arena(std::size_t capacity);
  /// Reads memory that `owner` owns: a file, or another arena. take() must not be called.
  Arena(const std::byte* data, std::size_t used, std::shared_ptr<const void> owner);
  Arena(Arena&& other) noexcept { swap(other); }
  Arena& operator=(Arena&& other) noexcept {
    swap(other);
    return *this;
  }
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;
  ~Arena();

  /// Takes the next `bytes`, rounded up to whole granules; zero-filled. Returns the number of the
  /// first granule. Precondition: it fits the capacity.
  std::uint32_t take(std::size_t bytes);
  /// Gives the untouched rest of the reservation back.
  void shrink_to_fit();

  std::byte* at(std::uint32_t granule) { return data_ + std::size_t{granule} * kGranule; }
  const std::byte* at(std::uint32_t granule) const {
    return data_ + std::size_t{granule} * kGranule;
  }
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
  std::shared_ptr<const void> owner_;  ///< of memory that is not the arena's own
};

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
