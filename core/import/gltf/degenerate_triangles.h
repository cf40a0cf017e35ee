#pragma once
/// Triangles of a mesh without an area in mesh space, and what is found on the way.

#include <cstdint>

#include "core/import/input/warnings.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

struct DegenerateTriangles {
  std::uint64_t nonfinite = 0;   ///< a corner is not finite
  std::uint64_t degenerate = 0;  ///< finite corners on one line, exactly
  bool all_used = false;         ///< each position is a corner of a triangle, of these too
};

/// Both kinds, in mesh space. A placement may flatten more triangles (a scale of zero), and the
/// rounding of its world positions may lift or flatten one by an ulp: those are not counted here.
/// Cost: a few nanoseconds per triangle, a byte for each position meanwhile. Parallel.
DegenerateTriangles count_degenerate_triangles(const Mesh& mesh);

/// Adds what was found in a mesh to the counts, and warns of it.
void add_degenerate_triangles(const DegenerateTriangles& found, const Mesh& mesh,
                              ImportCounts& counts, Warnings& warnings);

}  // namespace sightline::gltf

// Tests: tests/unit/import/mesh_reader_test.cpp
