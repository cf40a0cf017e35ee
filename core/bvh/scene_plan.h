#pragma once
/// ScenePlan: the meshes and placements of a scene before any tree is built, with the bounds that
/// builders need.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/index_column.h"
#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// A view of a mesh; the arrays belong to the caller.
struct MeshView {
  std::span<const Vec3f> positions;
  IndexView indices;      ///< three per triangle, all below positions.size()
  bool all_used = false;  ///< true: each position is a corner of a triangle; false: not known

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(indices.size() / 3); }
};

/// A mesh at a place in the world.
struct PlacementView {
  std::uint32_t mesh = 0;  ///< index in ScenePlan::meshes
  Affine world_from_mesh;
  bool hidden = false;  ///< a hidden placement has no bounds, so no ray meets it
};

/// Properties of a mesh that decide how its trees are built.
struct MeshFacts {
  bool finite = true;      ///< all positions are finite
  Box3d box;               ///< bounds of the finite positions, also of those that no triangle uses
  std::uint32_t uses = 0;  ///< number of placements that were not hidden when the scene was planned

  /// The largest |coordinate| of finite positions on an axis.
  double largest(int axis) const { return std::max({0.0, -box.min[axis], box.max[axis]}); }
};

/// The plan refers to the arrays of the meshes, which must outlive it.
struct ScenePlan {
  std::vector<MeshView> meshes;
  /// The given placements. If several meshes have equal content, their placements all name the
  /// first of these meshes.
  std::vector<PlacementView> placements;
  std::vector<MeshFacts> facts;  ///< one for each mesh
  /// For each placement, the bounds of the world triangles whose three corners are finite.
  std::vector<Box3d> placed;
  Box3d bounds;                ///< union of `placed`
  std::uint32_t distinct = 0;  ///< number of meshes that some placement names
};

/// Plans a scene. Parallel. Cost: reads every position and index once for each mesh, and every
/// position that a triangle uses once more for each placement. Errors: SCENE_TOO_LARGE if a mesh
/// has more triangles, or the scene has more placements, than a tree can hold.
Result<ScenePlan> plan_scene(std::vector<MeshView> meshes, std::vector<PlacementView> placements);

/// The new place of a placement of a plan.
struct MovedPlacement {
  std::uint32_t number = 0;  ///< index in ScenePlan::placements
  Affine world_from_mesh;
  bool hidden = false;
};
/// The plan of the same scene with some placements changed. Cost: that of plan_scene for the meshes
/// of these placements only.
ScenePlan moved_plan(const ScenePlan& before, std::span<const MovedPlacement> moved);

}  // namespace sightline
