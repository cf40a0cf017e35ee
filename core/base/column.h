#pragma once
/// Column<T>: a std::vector whose storage is 64-byte aligned, so that kernels may load whole cache
/// lines. Batches are structs of columns, one element per ray, query or hit.

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/pages.h"

namespace sightline {

/// Allocates storage at multiples of 64 bytes, the size of a cache line.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::size_t kAlignment = 64;  ///< in bytes

  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}

  T* allocate(std::size_t count) {
    if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T)) throw std::bad_array_new_length();
    // Allocates an ordinary block and moves the start up: glibc caches short ordinary blocks for
    // each thread, but searches a heap under a lock for an aligned one. The byte before the storage
    // holds the distance.
    auto* const block = static_cast<unsigned char*>(::operator new(count * sizeof(T) + kAlignment));
    const std::size_t moved = kAlignment - reinterpret_cast<std::uintptr_t>(block) % kAlignment;
    block[moved - 1] = static_cast<unsigned char>(moved);
    return reinterpret_cast<T*>(block + moved);
  }
  void deallocate(T* pointer, std::size_t) noexcept {
    auto* const storage = reinterpret_cast<unsigned char*>(pointer);
    ::operator delete(storage - storage[-1]);
  }

  template <class U>
  bool operator==(const AlignedAllocator<U>&) const {
    return true;
  }
};

/// A std::vector with storage at a multiple of 64 bytes; new elements are value-initialised.
template <class T>
using Column = std::vector<T, AlignedAllocator<T>>;

/// Leaves an element uninitialised where no value is given. Filling a hundred megabytes with zeros,
/// only to overwrite them, takes as long as reading them from a file. Blocks of at least
/// kLargeMemory come directly from the system (pages.h), so that several threads may touch their
/// pages first.
template <class T>
struct UnsetAllocator : AlignedAllocator<T> {
  template <class U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
  UnsetAllocator() = default;
  template <class U>
  UnsetAllocator(const UnsetAllocator<U>&) {}

  T* allocate(std::size_t count) {
    if (count < kLargeMemory / sizeof(T)) return AlignedAllocator<T>::allocate(count);
    if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T)) throw std::bad_array_new_length();
    return static_cast<T*>(take_pages(count * sizeof(T)));
  }
  void deallocate(T* pointer, std::size_t count) noexcept {
    if (count < kLargeMemory / sizeof(T)) return AlignedAllocator<T>::deallocate(pointer, count);
    give_pages(pointer, count * sizeof(T));
  }

  void construct(T*) noexcept {}
  template <class... Values>
  void construct(T* at, Values&&... values) {
    ::new (static_cast<void*>(at)) T(std::forward<Values>(values)...);
  }
};

/// A column whose constructor and resize leave new elements uninitialised: write before you read.
template <class T>
requires std::is_trivially_copyable_v<T>
using UnsetColumn = std::vector<T, UnsetAllocator<T>>;

}  // namespace sightline

// Tests: tests/unit/query/box_batch_test.cpp
