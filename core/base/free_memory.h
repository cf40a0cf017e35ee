#pragma once
/// Returns freed memory from the allocator to the system.

#include <cstdint>
#include <memory>
#include <utility>

namespace sightline {

/// Limits how much freed memory glibc's allocator retains. The allocator has up to eight heaps per
/// core, and each would retain the most that it ever needed: 400 MiB after 150 answers of 5 MB.
/// Must be called before the process starts a thread.
void limit_heaps();

/// Returns the unused memory of all heaps to the system. Without it, freed memory below a younger
/// block stays with the allocator; after a large scene or much JSON, that is most of the memory.
/// The free end of a heap stays, up to the threshold that limit_heaps sets. A lower threshold would
/// make the buffers of every large query fresh pages.
void give_back_free_memory();
/// Fewer freed bytes are not worth a call of give_back_free_memory, which walks all heaps: for each
/// of ten thousand small scenes that took longer than loading it.
inline constexpr std::uint64_t kWorthGivingBack = 64 << 10;
/// Calls give_back_free_memory if `bytes`, the memory that was freed, is at least kWorthGivingBack.
inline void give_back_free_memory_of(std::uint64_t bytes) {
  if (bytes >= kWorthGivingBack) give_back_free_memory();
}

/// Returns a pointer to the same object. When the last copy of that pointer is dropped, the object
/// is freed and give_back_free_memory is called. `bytes` is the memory of the object; below
/// kWorthGivingBack the argument is returned unchanged.
template <class T>
std::shared_ptr<const T> giving_back_memory(std::shared_ptr<const T> object, std::uint64_t bytes) {
  if (bytes < kWorthGivingBack) return object;
  const T* const pointer = object.get();
  return {pointer, [held = std::move(object)](const T*) mutable {
            held.reset();
            give_back_free_memory();
          }};
}

}  // namespace sightline

// Tests: tests/unit/server/request_memory_test.cpp
