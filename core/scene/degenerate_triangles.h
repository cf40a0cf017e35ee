#pragma once
/// Counts triangles of a mesh that have no area in mesh space.

#include <cstdint>

#include "core/scene/mesh.h"

namespace sightline {

/// The counts of a mesh.
struct DegenerateTriangles {
  std::uint64_t nonfinite = 0;   ///< a corner is not finite
  std::uint64_t degenerate = 0;  ///< finite corners on one line, exactly
  bool all_used = false;  ///< each position is a corner of a triangle, degenerate ones included
};

/// Counts both kinds in mesh space. A placement may flatten more triangles (a scale of zero), and
/// rounding of world positions may change whether one is flat; such triangles are not counted.
/// Parallel. Cost: a few nanoseconds per triangle, and a byte of memory per position during the
/// call.
DegenerateTriangles count_degenerate_triangles(const Mesh& mesh);

}  // namespace sightline

// Tests: tests/unit/import/mesh_reader_test.cpp
