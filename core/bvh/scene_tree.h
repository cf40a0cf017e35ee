#pragma once
/// The trees of a scene: one for all that is not worth sharing, one per shared mesh, and one over
/// the placements of shared ones where there are any.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/bvh/scene_plan.h"
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

/// Which placements share one tree around their world triangles.
enum class Joining {
  kMeasured,  ///< those whose meshes are placed once, and more where memory allows: choose_joined
  kNever,     ///< every placement is entered on its own
};

/// How a ray gets from the world into the space of a placement's tree, and how far off it may then
/// be (docs/explanation/exactness.md, "Instances"). x_tree = inverse * (x_world - translation).
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
  std::uint32_t tree = 0;  ///< index in SceneTree::trees
  /// World corners are the mesh's: world_from_mesh changes no number, nor does that of any
  /// placement that shares a tree of the world with this one.
  bool identity = true;
  bool diagonal = true;        ///< world_from_mesh is: world corners cost a third
  bool world_boxes = true;     ///< the tree's boxes are in world units: rays need no mapping
  std::uint32_t instance = 0;  ///< the scene's number for it
  Affine world_from_mesh;
  TreeSpace space;  ///< read only if !world_boxes
  /// World edges are at most edge_scale * (mesh edge_max) + edge_pad on every axis.
  double edge_scale = 1;
  double edge_pad = 0;
};

/// Never changes once it is shared.
struct SceneTree {
  std::vector<std::shared_ptr<const WideTree>> trees;
  /// Those with something to hit. The first `entries` are entered one by one. All behind them
  /// share the tree of the last of those, which has world boxes. In every tree a leaf block says by
  /// `placement` how far behind the entered placement its own one stands.
  std::span<const Placement> placements;
  std::shared_ptr<const std::vector<Placement>> placement_memory;
  std::uint32_t entries = 0;
  /// Over the entries; leaf blocks hold indices of placements in `triangle`. Need not be there for
  /// fewer than two entries.
  WideTree top;
  std::shared_ptr<const WideTree> top_memory;  ///< what `top` is an alias of, if it is one
  Box3d bounds;             ///< of all finite world triangles, whether they can be hit or not
  std::uint32_t depth = 0;  ///< nodes on the longest way down: through the top, then a tree
  /// Stands in `trees` for each that is not built yet, and has nothing to hit. Null where all are.
  std::shared_ptr<const WideTree> unbuilt;
  std::uint32_t unbuilt_count = 0;  ///< how many are not built

  bool complete() const { return unbuilt_count == 0; }
  bool is_unbuilt(std::uint32_t tree) const { return unbuilt_count > 0 && trees[tree] == unbuilt; }
  void set_placements(std::vector<Placement> all) {
    placement_memory = std::make_shared<const std::vector<Placement>>(std::move(all));
    placements = *placement_memory;
  }
  /// Bytes of all trees.
  std::uint64_t bytes() const;
};

/// Builds all trees. Placements of meshes that are placed once, or are small, share one tree around
/// their world triangles. A larger mesh that is placed often has one tree in its own space. An
/// exception is a matrix that is so nearly singular that mapped rays would lose their precision:
/// its placement has a tree of its own. Errors: SCENE_TOO_LARGE if a tree would exceed 16 GiB;
/// CANCELLED, soon after `cancel` is.
Result<SceneTree> build_scene_tree(const ScenePlan& plan, TreeQuality quality = TreeQuality::kHigh,
                                   Joining joining = Joining::kMeasured,
                                   const CancelFlag* cancel = nullptr);
Result<SceneTree> build_scene_tree(std::span<const MeshView> meshes,
                                   std::span<const PlacementView> placements,
                                   TreeQuality quality = TreeQuality::kHigh,
                                   Joining joining = Joining::kMeasured);

}  // namespace sightline

// Tests: tests/unit/bvh/joining_test.cpp
