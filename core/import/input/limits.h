#pragma once
/// ImportLimits: limits that bound the time and the memory of an import.

#include <cstdint>

namespace sightline {

/// The most of each thing that a scene file may have. A file that exceeds a limit is refused.
struct ImportLimits {
  std::uint64_t file_bytes = 1ull << 33;    ///< size of the scene file, and of each external buffer
  std::uint64_t json_bytes = 256ull << 20;  ///< size of the JSON text
  std::uint32_t json_depth = 256;           ///< levels of nested arrays and objects
  std::uint64_t json_values = 16u << 20;    ///< numbers, strings, arrays, ... in the JSON text
  std::uint64_t triangles = 1ull << 31;     ///< in all meshes, each mesh counted once
  std::uint32_t nodes = 4u << 20;           ///< in the file
  std::uint32_t node_depth = 4096;          ///< levels of nodes below a root
  std::uint32_t instances = 16u << 20;      ///< placements of meshes in the loaded scene
  /// Bytes of positions, indices and instances in memory. The size of the file does not bound them,
  /// because many accessors may refer to the same bytes.
  std::uint64_t geometry_bytes = 1ull << 33;
  std::uint32_t zero_filled = 1u << 22;  ///< elements of an accessor that has no bytes in the file
};

}  // namespace sightline

// Tests: tests/unit/import/json_guard_test.cpp
