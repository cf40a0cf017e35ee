#pragma once
/// Mesh: triangles in the mesh's own space, as the file encodes them.

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/index_column.h"
#include "core/geometry/box3.h"
#include "core/geometry/vec3.h"
#include "core/scene/vertex_numbers.h"

namespace sightline {

/// A range of a mesh's triangles with one material: a glTF primitive.
struct Primitive {
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t file_primitive =
      0;  ///< index in the primitives of the file's mesh; points and lines count, but are left out
  /// Index in SceneDescription::materials; 0xffffffff: none.
  std::uint32_t material = 0xffffffffu;
};

/// A mesh. Positions are float32 as decoded (docs/reference/contract.md, "The scene", 1). Triangle
/// i has the corners positions[indices[3i]], [3i+1], [3i+2]; every index is below positions.size().
/// Strips and fans are unrolled with glTF's winding. Positions may be non-finite, and triangles may
/// have no area. Such triangles have a number like all others, and are never hit.
struct Mesh {
  std::string name;
  std::uint32_t file_mesh = 0;  ///< index in the file's "meshes"
  SharedColumn<Vec3f> positions;
  /// Importers store the indices 0, 1, 2, ... as a sequence without memory.
  IndexColumn indices;
  bool all_used = false;  ///< each position is a corner of a triangle; false: not checked
  /// a hash of the positions if a client replaced those of the file; 0: it did not
  std::uint64_t edited = 0;
  /// of ImportCounts; 0 if they were not counted
  std::uint64_t nonfinite_triangles = 0, degenerate_triangles = 0;
  std::vector<Primitive> primitives;
  /// Vertex attributes by primitive, up to the last primitive that has any.
  std::vector<PrimitiveAttributes> attributes;

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(indices.size() / 3); }
};

}  // namespace sightline

// Tests: tests/unit/scene/open_edges_test.cpp
