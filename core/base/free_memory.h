#pragma once
/// Memory that was freed goes back to the system, not only to the allocator.

#include <cstdint>
#include <memory>
#include <utility>

namespace sightline {

/// Limits the freed memory that glibc's allocator retains. For each of up to eight heaps per core, it
/// would retain the most that the heap ever needed: 400 MiB after 150 answers of 5 MB. To be called
/// before any thread is made.
void limit_heaps();

/// Returns unused memory to the system. The allocator retains freed memory that lies below younger
/// blocks. After a large scene or a file with much JSON, that is most of what it took. The free end
/// of each heap stays, up to the allocator's threshold (64 MiB at most). A lower threshold would
/// make the buffers of every large query fresh pages.
void give_back_free_memory();
/// Below that it does not pay: walking all heaps for each of ten thousand small scenes took longer
/// than loading them.
inline constexpr std::uint64_t kWorthGivingBack = 64 << 10;
/// Calls give_back_free_memory after work on so many bytes, if they are many.
inline void give_back_free_memory_of(std::uint64_t bytes) {
  if (bytes >= kWorthGivingBack) give_back_free_memory();
}

/// Wraps an object so that dropping the last reference returns its memory to the system, if it was
/// made of enough bytes.
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
