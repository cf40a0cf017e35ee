#pragma once
/// The plan of a scene before any tree is built: its bounds, and the inputs of its trees.

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

/// A mesh as the builder sees it; the arrays belong to the caller.
struct MeshView {
  std::span<const Vec3f> positions;
  IndexView indices;      ///< three per triangle, all in range
  bool all_used = false;  ///< each position is a corner of a triangle; false: it is not known

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(indices.size() / 3); }
};

struct PlacementView {
  std::uint32_t mesh = 0;
  Affine world_from_mesh;
  bool hidden = false;  ///< has no bounds, so nothing meets it
};

struct MeshFacts {
  bool finite = true;      ///< every position is
  Box3d box;               ///< of finite positions, those that no triangle uses included
  std::uint32_t uses = 0;  ///< placements that were not hidden when it was planned

  /// The largest |coordinate| of finite positions.
  double largest(int axis) const { return std::max({0.0, -box.min[axis], box.max[axis]}); }
};

/// Holds views: the arrays of the meshes outlive it.
struct ScenePlan {
  std::vector<MeshView> meshes;
  /// The given placements. Meshes with the same content are all named by the first of them.
  std::vector<PlacementView> placements;
  std::vector<MeshFacts> facts;  ///< one for each mesh
  /// One for each placement: bounds of the world triangles whose three corners are finite.
  std::vector<Box3d> placed;
  Box3d bounds;                ///< of all of them
  std::uint32_t distinct = 0;  ///< meshes that are placed under their own number
};

/// Parallel. Cost: every position and index is read once for each mesh, every position that a
/// triangle uses once more for each placement. Errors: SCENE_TOO_LARGE for a mesh, or for so many
/// placements, that no tree holds.
Result<ScenePlan> plan_scene(std::vector<MeshView> meshes, std::vector<PlacementView> placements);

/// A placement of a plan that is to be elsewhere.
struct MovedPlacement {
  std::uint32_t number = 0;
  Affine world_from_mesh;
  bool hidden = false;
};
/// The plan of the same scene with some placements elsewhere. Cost: as plan_scene for the meshes of
/// those alone.
ScenePlan moved_plan(const ScenePlan& before, std::span<const MovedPlacement> moved);

}  // namespace sightline
