#pragma once
/// Whether there is memory for what libraries build from JSON text, asked before they begin.
///
/// nlohmann's destructor moves the values of a document to a stack on the heap: where that
/// allocation fails, in a function that may not throw, the process ends. So a document is only
/// begun when there is room for all of it and for its end.

#include <cstdint>

#include "core/base/result.h"

namespace sightline::gltf {

/// Counts of the parts of a JSON text.
struct JsonSize {
  std::uint64_t values = 0;    ///< of any kind; those below are among them
  std::uint64_t elements = 0;  ///< values in arrays
  std::uint64_t members = 0;   ///< values in objects, each with its key
  std::uint64_t arrays = 0, objects = 0, strings = 0;
  std::uint64_t bytes = 0;  ///< of the text
};

/// A bound of what nlohmann's document of such a text takes at its largest: while it grows, while
/// it is written as text again, and while it is destroyed.
std::uint64_t document_bytes(const JsonSize& size);

/// Reserves twice these bytes of address space, because another thread may be growing as well, and
/// gives them back. Refused under a limit of the address space (ulimit -v) or of what the system
/// promises (overcommit off), which are what makes an allocation fail.
/// Errors: GLTF_OUT_OF_MEMORY.
Status try_memory(std::uint64_t bytes);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
