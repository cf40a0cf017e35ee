#pragma once
/// The limits that bound the time and the memory of an import.

#include <cstdint>

namespace sightline {

struct ImportLimits {
  std::uint64_t file_bytes = 1ull << 33;  ///< the scene file and each external buffer
  std::uint64_t json_bytes = 256ull << 20;
  std::uint32_t json_depth = 256;
  std::uint64_t json_values = 16u << 20;  ///< numbers, strings, arrays, ... in the JSON text
  std::uint64_t triangles = 1ull << 31;   ///< over unique meshes
  std::uint32_t nodes = 4u << 20;
  std::uint32_t node_depth = 4096;
  std::uint32_t instances = 16u << 20;
  /// Positions, indices and instances in memory. Many accessors may show the same bytes of the
  /// file, so the file's size alone does not bound it.
  std::uint64_t geometry_bytes = 1ull << 33;
  std::uint32_t zero_filled = 1u << 22;  ///< elements of an accessor that has no bytes in the file
};

}  // namespace sightline

// Tests: tests/unit/import/json_guard_test.cpp
