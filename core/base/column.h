#pragma once
/// Column<T>: a std::vector whose storage is 64-byte aligned, so that kernels may load whole cache
/// lines. Batches are structs of columns, one element per ray, query or hit.

#include <cstddef>
#include <new>
#include <vector>

namespace sightline {

template <class T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};

  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}

  T* allocate(std::size_t count) {
    if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T)) throw std::bad_array_new_length();
    return static_cast<T*>(::operator new(count * sizeof(T), kAlignment));
  }
  void deallocate(T* pointer, std::size_t) noexcept { ::operator delete(pointer, kAlignment); }

  template <class U>
  bool operator==(const AlignedAllocator<U>&) const {
    return true;
  }
};

template <class T>
using Column = std::vector<T, AlignedAllocator<T>>;

}  // namespace sightline
