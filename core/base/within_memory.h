#pragma once
/// within_memory: turns std::bad_alloc into an error.

#include <new>

#include "core/base/result.h"

namespace sightline {

/// Returns the Result of work(). If work throws std::bad_alloc, returns the error MEMORY_EXHAUSTED
/// with `message`.
template <class Work>
auto within_memory(const char* message, const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::kOutOfSpace, "MEMORY_EXHAUSTED", message, ""};
  }
}

}  // namespace sightline

// Tests: tests/unit/run/memory_test.cpp
