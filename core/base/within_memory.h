#pragma once
/// Turns std::bad_alloc into an error.

#include <new>

#include "core/base/result.h"

namespace sightline {

/// Calls work(), which returns a Result. If an allocation fails, returns the error MEMORY_EXHAUSTED
/// with this message.
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
