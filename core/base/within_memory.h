#pragma once
/// Where memory may run out.

#include <new>

#include "core/base/result.h"

namespace sightline {

/// Calls work(), which returns a Result; what it could not allocate is the error MEMORY_EXHAUSTED
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
