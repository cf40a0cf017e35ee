#pragma once
/// Changes of nodes that clients made after the file was loaded.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/scene/edited_meshes.h"
#include "core/scene/poser.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// A change of a scene by a client. What `nodes` sets replaces what the animation sets.
struct SceneChange {
  std::optional<AnimationTime> animation;  ///< the nodes that it targets stand as it says
  std::vector<NodeChange> nodes;
};
/// The changes of nodes that a SceneChange consists of.
struct ResolvedChange {
  std::vector<NodeChange> nodes;  ///< in the order in which they apply
  std::size_t sampled = 0;        ///< so many of the first are those of the animation
};
/// True if the change calls the scene's Poser: it has an animation or weights, or moves a joint.
bool may_pose(const SceneDescription& scene, const SceneChange& change);
/// Samples the animation, if there is one. Copies of nodes with positions that a client set get
/// these. Errors: ANIMATION_UNKNOWN (also of a scene without a Poser), those of Poser::sample.
Result<ResolvedChange> resolve(const SceneDescription& scene, const SceneChange& change);

/// All changes of a scene: one for each changed node. Nodes of the file come first, ascending; added
/// nodes follow in the order of their additions.
using NodeChanges = std::vector<NodeChange>;
/// Returns `changes` with the changes of `more` added in order: members of a change that have a
/// value replace those of the earlier change of its node, if there is one.
NodeChanges with_changes(NodeChanges changes, std::span<const NodeChange> more);

/// Drops what the changes of removed nodes no longer need. `scene`: after all changes.
void forget_removed(const SceneDescription& scene, NodeChanges& changes);

/// What change_nodes changed.
struct ChangedInstances {
  /// instances that moved, were hidden or shown, or have a mesh of another pose; ascending
  std::vector<std::uint32_t> instances;
  PosedMeshes posed;
};

/// Applies changes to the nodes of a scene description. Nodes below a changed node move and hide
/// with it, by the importer's formulas. Masks of instances are computed again. If joints move or
/// morph weights change, the scene's Poser makes their meshes again. After an error the description
/// must not be used. Additions come first and removals last, whatever the order of the changes.
/// Errors: those of Poser::pose, add_nodes and set_positions, and
///   NODE_NOT_FOUND      with the pointer /nodes/N of change N + `sampled`
///   NODE_WEIGHTS_WRONG  with /nodes/N/weights; the node has another number of morph targets, or none
///   NODE_POSES_SKIN     a pose would change, and the scene has no Poser
///   TRANSFORM_INVALID   a matrix, alone or multiplied by those of its parents or a placement,
///                       exceeds float32
/// `held`: see set_positions.
Result<ChangedInstances> change_nodes(SceneDescription& scene, std::span<const NodeChange> changes,
                                      std::size_t sampled = 0, const HeldMeshes& held = {});
/// Returns the effective mask of each node: its own, or that of its nearest parent with a mask, or
/// all bits.
std::vector<std::uint32_t> node_masks(const SceneDescription& scene);

}  // namespace sightline

// Tests: tests/unit/run/moved_test.cpp
