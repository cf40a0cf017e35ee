#pragma once
/// ScenePlan: the meshes and placements of a scene before any tree is built, with the bounds that
/// builders need. plan_scene makes it.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/index_column.h"
#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// A view of a mesh; the arrays belong to the caller and must outlive the view.
struct MeshView {
  std::span<const Vec3f> positions;  ///< in mesh space; need not be finite
  IndexView indices;                 ///< three per triangle, all below positions.size()
  bool all_used = false;  ///< true: each position is a corner of a triangle; false: not known

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(indices.size() / 3); }
};

/// A mesh at a place in the world: the input of plan_scene.
struct PlacementView {
  std::uint32_t mesh = 0;  ///< index in ScenePlan::meshes
  Affine world_from_mesh;
  bool hidden = false;  ///< a hidden placement has no bounds, so no ray meets it
};

/// Properties of a mesh that decide how its trees are built.
struct MeshFacts {
  bool finite = true;  ///< all positions are finite
  Box3d box;           ///< bounds of the finite positions, also of those that no triangle uses
  /// number of placements that were not hidden when the scene was planned; at least 1 after
  /// moved_plan shows one
  std::uint32_t uses = 0;

  /// The largest |coordinate| of finite positions on an axis.
  double largest(int axis) const { return std::max({0.0, -box.min[axis], box.max[axis]}); }
};

/// The corners of a mesh, and boxes of groups of them, by which bounds of many placements cost
/// little.
struct CornerGroups {
  /// Indices in MeshView::positions that triangles use; empty: all are used.
  std::vector<std::uint32_t> corners;
  /// Boxes of kCorners consecutive corners each, in mesh space. Empty if the mesh is small, is
  /// placed rarely, or has a position that is not finite.
  std::vector<Box3d> boxes;

  static constexpr std::size_t kCorners = 16;
};

/// The usual most triangles of a tree. A tree of so many triangles has at most 16 GiB (WideTree),
/// and one leaf block can name any of them (LeafBlock::kNear).
inline constexpr std::uint32_t kTreeTriangles = 1u << 25;

/// The plan of a scene. It refers to the arrays of the meshes, which must outlive it.
struct ScenePlan {
  std::vector<MeshView> meshes;
  /// The given placements, in their order. If several meshes have equal content, their placements
  /// all name the first of these meshes.
  std::vector<PlacementView> placements;
  std::vector<MeshFacts> facts;  ///< one for each mesh
  /// One for each mesh; null if no placement of it was ever visible.
  std::vector<std::shared_ptr<const CornerGroups>> groups;
  /// For each placement, a box that contains the world triangles whose three corners are finite;
  /// empty if there are none, or if the placement is hidden
  std::vector<Box3d> placed;
  /// For each placement, 1 if `placed` is the union of the mapped boxes of `groups`; 0 if it is
  /// exact.
  std::vector<std::uint8_t> is_loose;
  Box3d bounds;                ///< exact_bounds of all placements
  std::uint32_t distinct = 0;  ///< number of meshes with uses > 0
  /// A mesh with more triangles has several trees (cut_mesh). At most kTreeTriangles.
  std::uint32_t tree_triangles = kTreeTriangles;

  /// The bounds of the world triangles, with three finite corners each, of the placements [first,
  /// first + count). Cost: little more than reading `placed`, by branch and bound over `groups`.
  Box3d exact_bounds(std::size_t first, std::size_t count) const;
  /// True if the mesh of an index has several trees.
  bool is_cut(std::uint32_t mesh) const { return meshes[mesh].triangle_count() > tree_triangles; }
};

/// Plans a scene. Parallel. Cost: reads every position and index twice for each mesh, and for each
/// placement every position that a triangle uses, or every box of its `groups`. Precondition: the indices of meshes
/// are in range. `tree_triangles` is that of the plan; tests choose small ones. Errors:
/// SCENE_TOO_LARGE if a mesh has 2^32 triangles or more, or if the scene has more placements than a
/// tree can hold. Throws std::bad_alloc.
Result<ScenePlan> plan_scene(std::vector<MeshView> meshes, std::vector<PlacementView> placements,
                             std::uint32_t tree_triangles = kTreeTriangles);

/// The new position of a placement of a plan.
struct MovedPlacement {
  /// index in ScenePlan::placements; its size for a placement that is added
  std::uint32_t number = 0;
  Affine world_from_mesh;  ///< the new map
  bool hidden = false;     ///< whether it is hidden from now on
  std::uint32_t mesh = 0;  ///< the new value of PlacementView::mesh
};
/// A mesh of a plan with other content.
struct FreshMesh {
  std::uint32_t number = 0;  ///< index in ScenePlan::meshes; its size for a mesh that is added
  MeshView view;
};
/// The plan of the scene `before` with some placements changed or added, each named once, and some
/// meshes replaced or added; both are in ascending order. Precondition: a placement that does not
/// change names no replaced mesh. Cost: that of plan_scene for the meshes of these placements only,
/// and a copy of `before`. Errors: SCENE_TOO_LARGE as of plan_scene. Throws std::bad_alloc.
Result<ScenePlan> moved_plan(const ScenePlan& before, std::span<const MovedPlacement> moved,
                             std::span<const FreshMesh> fresh = {});

}  // namespace sightline
