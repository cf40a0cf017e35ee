#pragma once
/// Splits the triangles of a large mesh into parts of neighbours, in about two passes over them. A
/// first ray into ten million triangles then needs only the tree of one part. The parts are the
/// cells of a grid over the bounds, joined along a Morton curve. Also cuts a mesh that is too large
/// for one tree.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/bvh/scene_plan.h"
#include "core/geometry/box3.h"

namespace sightline {

/// The usual most triangles of a part. If more triangles than that lie in one cell of the grid,
/// their part is larger; it may be split again.
inline constexpr std::uint32_t kPartTriangles = 1u << 12;

/// A range of consecutive triangle numbers of a mesh. Files list neighbours one after the other, so
/// a part has few ranges.
struct TriangleRun {
  std::uint32_t first;
  std::uint32_t count;
};
/// The numbers of all triangles of the ranges, in the order of the ranges. Throws std::bad_alloc.
std::vector<std::uint32_t> numbers_of(std::span<const TriangleRun> runs);

/// The ranges sorted by number, neighbours joined. Precondition: they do not overlap. Throws
/// std::bad_alloc.
std::vector<TriangleRun> ascending(std::span<const TriangleRun> runs);

/// A part of a mesh.
struct MeshPart {
  std::span<const TriangleRun> runs;  ///< the triangles of the part
  std::uint32_t triangle_count = 0;
  std::shared_ptr<const void> owner;  ///< owns the memory of `runs`
  Box3d box;                          ///< contains the triangles, in the space of world_from_mesh
};

/// Splits the given triangles of the mesh, or all if `triangles` is empty. world_from_mesh is null
/// for parts in the mesh's own space. Leaves out triangles with a corner that is not finite or with
/// two equal vertex indices: nothing can hit them. `bounds` must contain the corners of the others.
/// Returns one part if there are at most kPartTriangles, or if all lie in one cell. Parallel; the
/// result does not depend on the number of threads. Throws std::bad_alloc.
std::vector<MeshPart> split_mesh(const MeshView& mesh, const Affine* world_from_mesh,
                                 std::span<const std::uint32_t> triangles, const Box3d& bounds);

/// Cuts the triangles of a part into parts with at most `most` triangles each, for meshes that are
/// too large for one tree: neighbours along the curve of split_mesh share a part. A `whole` without
/// runs means all triangles of the mesh. The runs of the results ascend. Parallel; the result
/// does not depend on the number of threads. Throws std::bad_alloc.
std::vector<MeshPart> cut_mesh(const MeshView& mesh, const Affine* world_from_mesh,
                               const MeshPart& whole, std::uint32_t most);

}  // namespace sightline
