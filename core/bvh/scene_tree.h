#pragma once
/// The trees of a scene: one per mesh, and one over the placements where there is more than one.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/bvh/wide_tree.h"
#include "core/geometry/affine.h"
#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// How much time a tree may take.
enum class TreeQuality {
  kFast,  ///< soon
  kHigh,  ///< subtrees moved to better places: docs/decisions/0008
};

/// A mesh as the builder sees it; the arrays belong to the caller and are not kept.
struct MeshView {
  std::span<const Vec3f> positions;
  std::span<const std::uint32_t> indices;  ///< three per triangle, all in range

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(indices.size() / 3); }
};

/// How a ray gets from the world into the space of a placement's tree, and how far off it may then
/// be (docs/exactness.md, "Instances"). x_tree = inverse * (x_world - translation).
struct TreeSpace {
  double inverse[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double translation[3] = {0, 0, 0};
  /// Tree units; on every axis at least the distance by which the mapped world triangles may lie
  /// outside the boxes of the tree.
  double pad[3] = {0, 0, 0};
  /// On every world axis at least |coordinate| of the placed triangles plus |translation|.
  double reach[3] = {0, 0, 0};
};

/// One placed mesh. The world triangles are world_from_mesh applied to the float32 corners.
struct Placement {
  std::uint32_t tree = 0;      ///< index in SceneTree::trees
  bool identity = true;        ///< world_from_mesh changes no number
  bool world_boxes = true;     ///< the tree's boxes are in world units: rays need no mapping
  std::uint32_t instance = 0;  ///< the scene's number for it
  Affine world_from_mesh;
  TreeSpace space;  ///< read only if !world_boxes
  /// World edges are at most edge_scale * (mesh edge_max) + edge_pad on every axis.
  double edge_scale = 1;
  double edge_pad = 0;
};

struct SceneTree {
  std::vector<std::unique_ptr<WideTree>> trees;
  std::vector<Placement> placements;  ///< those with something to hit
  /// Over the placements; leaf blocks hold indices of placements in `triangle`. Empty if there are
  /// fewer than two placements.
  WideTree top;
  Box3d bounds;             ///< of all finite world triangles
  std::uint32_t depth = 0;  ///< nodes on the longest way down: through the top, then a tree
};

struct PlacementView {
  std::uint32_t mesh = 0;
  Affine world_from_mesh;
};

/// Builds everything. A mesh placed once gets boxes around its world triangles; one placed often
/// has one tree in its own space, unless a matrix is so nearly singular that mapping rays would
/// cost their precision: then that placement has a tree of its own. Errors: SCENE_TOO_LARGE if a
/// tree would pass 16 GiB.
Result<SceneTree> build_scene_tree(std::span<const MeshView> meshes,
                                   std::span<const PlacementView> placements,
                                   TreeQuality quality = TreeQuality::kHigh);

}  // namespace sightline
