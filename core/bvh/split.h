#pragma once
/// Cuts the triangles of a large mesh into parts that lie together, in about two passes: what a
/// first ray needs of ten million triangles is one small tree.

#include <cstdint>
#include <span>
#include <vector>

#include "core/bvh/scene_plan.h"
#include "core/geometry/box3.h"

namespace sightline {

/// Triangles of a part, unless so many lie in one place that a finer grid is needed: such a part
/// may be cut again.
inline constexpr std::uint32_t kPartTriangles = 1u << 14;

struct MeshPart {
  std::vector<std::uint32_t> triangles;
  Box3d box;  ///< of them, in the space of the trees
};

/// Of `triangles` of the mesh, or of all where that is empty. Those that nothing can hit are left
/// out (tree_corners). `bounds` contain their corners. At least two parts, unless all triangles lie
/// around one place. Parallel; does not depend on the number of threads.
std::vector<MeshPart> split_mesh(const MeshView& mesh, const Affine* world_from_mesh,
                                 std::span<const std::uint32_t> triangles, const Box3d& bounds);

}  // namespace sightline
