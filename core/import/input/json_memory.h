#pragma once
/// Checks whether there is enough memory for a JSON document before the library builds it.
///
/// nlohmann's destructor moves the values of a document to a stack on the heap. If that allocation
/// fails, inside a function that must not throw, the process ends. So a document is built only if
/// there is memory for it and for its destruction.

#include <cstdint>

#include "core/base/result.h"

namespace sightline::gltf {

/// Counts of the parts of a JSON text.
struct JsonSize {
  std::uint64_t values = 0;    ///< values of any kind, those below included
  std::uint64_t elements = 0;  ///< values in arrays
  std::uint64_t members = 0;   ///< values in objects, each with its key
  std::uint64_t arrays = 0, objects = 0, strings = 0;
  std::uint64_t bytes = 0;  ///< size of the text
};

/// An upper bound of the bytes of memory that nlohmann's document of such a text needs at any time:
/// while it is built, while it is written as text, and while it is destroyed.
std::uint64_t document_bytes(const JsonSize& size);

/// Checks that `bytes` can be allocated: reserves twice as much address space, since another thread
/// may allocate as well, and releases it. The check fails under a limit of the address space
/// (ulimit -v), or if the system does not overcommit memory; only then can an allocation fail.
/// Errors: GLTF_OUT_OF_MEMORY.
Status try_memory(std::uint64_t bytes);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
