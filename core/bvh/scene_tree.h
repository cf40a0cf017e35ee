#pragma once
/// SceneTree: all trees of a scene. Meshes that are worth sharing have a tree each; the rest share
/// one tree in world space. An entry is a placement whose tree rays enter on its own, or the last
/// one, which stands for all that share a tree. A top tree holds the entries if there are several.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/bvh/scene_plan.h"
#include "core/bvh/split.h"
#include "core/bvh/wide_tree.h"
#include "core/geometry/affine.h"
#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// How much time the building of a tree may take.
enum class TreeQuality {
  kFast,  ///< built quickly
  kHigh,  ///< subtrees are moved to better places afterwards: docs/decisions/0008
};

/// Which placements share one tree in world space.
enum class Joining {
  kMeasured,  ///< those that choose_joined chooses
  kNever,     ///< none: every placement is an entry of its own
};

/// The map from world space to the space of a placement's tree, and bounds of its rounding errors
/// (docs/explanation/exactness.md, "Instances"): x_mesh = inverse * (x_world - translation). Boxes
/// of the tree are in these units times 2^scale_exponent.
struct TreeSpace {
  double inverse[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double translation[3] = {0, 0, 0};
  /// In mesh units: a bound, for each axis, of the distance by which mapped world triangles may lie
  /// outside of the boxes of the tree.
  double pad[3] = {0, 0, 0};
  /// In world units: a bound, for each axis, of |coordinate| of the placed triangles plus
  /// |translation|.
  double reach[3] = {0, 0, 0};
};

/// A mesh at a place in the world, and how rays enter its tree (placing.h). Its world triangles are
/// world_from_mesh applied to the float32 corners.
struct Placement {
  std::uint32_t tree = 0;  ///< index in SceneTree::trees
  /// True if world corners equal mesh corners: world_from_mesh changes no coordinate. If placements
  /// share a tree in world space, it is true only if that holds for all of them.
  bool identity = true;
  /// True if world_from_mesh only scales axes and translates: computing world corners then costs a
  /// third.
  bool diagonal = true;
  /// True if the boxes of the tree are around world triangles: rays are not mapped.
  bool world_boxes = true;
  /// Index in ScenePlan::placements. The parts of a split mesh are entries with one instance.
  std::uint32_t instance = 0;
  Affine world_from_mesh;
  TreeSpace space;  ///< set if !world_boxes
  /// In magnitude, each component of a world edge is at most edge_scale * edge_max() + edge_pad,
  /// with the edge_max() of its leaf block.
  double edge_scale = 1;
  double edge_pad = 0;
};

/// The trees of a scene. A SceneTree that is shared between threads never changes. Rays start at
/// `top`, or at entry 0 if it is the only entry.
struct SceneTree {
  /// The trees of placements, never null; Placement::tree is an index.
  std::vector<std::shared_ptr<const WideTree>> trees;
  /// The placements that may have something to hit. The first `entries` of them are the entries.
  /// The placements after these share the tree of the last entry, which has world boxes. Its leaf
  /// blocks name their placement by its distance from the last entry (LeafBlock::placement). A
  /// placement that has left that tree has the instance 0xffffffff.
  std::span<const Placement> placements;
  /// Owns the memory of `placements`.
  std::shared_ptr<const std::vector<Placement>> placement_memory;
  std::uint32_t entries = 0;  ///< number of entries
  /// The tree over the entries; its leaf blocks hold their indices in LeafBlock::triangle. May be
  /// empty (root kEmpty) if there are fewer than two entries.
  WideTree top;
  /// owner of the memory of `top` if `top` is an alias; else null
  std::shared_ptr<const WideTree> top_memory;
  Box3d bounds;  ///< bounds of all finite world triangles, with or without an area
  /// At least the number of nodes on the longest path through the top tree and then a tree.
  std::uint32_t depth = 0;
  /// A placeholder without triangles. It is an element of `trees` for each tree that is not built
  /// yet. Null if all are built.
  std::shared_ptr<const WideTree> unbuilt;
  std::uint32_t unbuilt_count = 0;  ///< number of trees that are not built

  /// True if all trees are built.
  bool complete() const { return unbuilt_count == 0; }
  /// True if the tree of an index in `trees` is not built.
  bool is_unbuilt(std::uint32_t tree) const { return unbuilt_count > 0 && trees[tree] == unbuilt; }
  /// Sets placements and placement_memory; `entries` is unchanged.
  void set_placements(std::vector<Placement> all) {
    placement_memory = std::make_shared<const std::vector<Placement>>(std::move(all));
    placements = *placement_memory;
  }
  /// Bytes of all trees that are built, the top tree included.
  std::uint64_t bytes() const;
  /// Those of them that are in OverflowMemory.
  std::uint64_t overflow_bytes() const;
};

/// In place of a placement: the tree is in the own space of its mesh.
inline constexpr std::uint32_t kOwnSpace = 0xffffffffu;

/// A tree of a placed mesh, or of a part of it, that is built before the other trees of its scene.
struct FinishedTree {
  std::uint32_t mesh = 0;  ///< index in ScenePlan::meshes
  /// Index in ScenePlan::placements if the tree is around the world triangles of that placement;
  /// kOwnSpace if it is in the mesh's own space.
  std::uint32_t placement = kOwnSpace;
  /// The triangles of the tree, as cut_mesh returns them; without runs: all of the mesh.
  MeshPart part;
  std::shared_ptr<const WideTree> tree;  ///< not null; may have no triangles
};

/// Builds all trees. Placements of meshes that are placed once, or are small, share one tree around
/// their world triangles. A larger mesh that is placed often has one tree in its own space. If a
/// matrix is so nearly singular that mapped rays would lose precision, its placement has a tree of
/// its own in world space. A mesh that is too large for one tree has several
/// (ScenePlan::tree_triangles). Errors: CANCELLED soon after `cancel` is set.
///
/// finished  called on this thread after each tree that placements do not share in world space;
///           may be empty
Result<SceneTree> build_scene_tree(const ScenePlan& plan, TreeQuality quality = TreeQuality::kHigh,
                                   Joining joining = Joining::kMeasured,
                                   const CancelFlag* cancel = nullptr,
                                   std::function<void(FinishedTree)> finished = {});
/// Plans the scene (plan_scene) and builds all trees.
Result<SceneTree> build_scene_tree(std::span<const MeshView> meshes,
                                   std::span<const PlacementView> placements,
                                   TreeQuality quality = TreeQuality::kHigh,
                                   Joining joining = Joining::kMeasured);

}  // namespace sightline

// Tests: tests/unit/bvh/joining_test.cpp
