#pragma once
/// Splits the triangles of a large mesh into parts of neighbours, in about two passes. A first ray
/// into ten million triangles then needs only one small tree.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/bvh/scene_plan.h"
#include "core/geometry/box3.h"

namespace sightline {

/// Triangles of a part, unless so many lie in one place that a finer grid is needed: such a part
/// may be cut again.
inline constexpr std::uint32_t kPartTriangles = 1u << 12;

/// Triangles of a mesh that have consecutive numbers. Files list neighbours one after the other, so
/// that a part has few runs.
struct TriangleRun {
  std::uint32_t first;
  std::uint32_t count;
};
std::vector<std::uint32_t> numbers_of(std::span<const TriangleRun> runs);

struct MeshPart {
  std::span<const TriangleRun> runs;
  std::uint32_t triangle_count = 0;
  std::shared_ptr<const void> owner;  ///< owns the runs of all parts
  Box3d box;                          ///< around the triangles, in the space of the trees
};

/// Of `triangles` of the mesh, or of all where that is empty. Those with a corner that is not
/// finite, or with one vertex twice, are left out: nothing can hit them. `bounds` contain the
/// corners of the others. At least two parts, unless all triangles lie
/// around one place. Parallel; does not depend on the number of threads.
std::vector<MeshPart> split_mesh(const MeshView& mesh, const Affine* world_from_mesh,
                                 std::span<const std::uint32_t> triangles, const Box3d& bounds);

}  // namespace sightline
