#pragma once
/// What a client has changed about the nodes of a scene, beside what its file says.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// What is empty stays as it is.
struct NodeChange {
  std::uint32_t node = 0;  ///< index in the file's "nodes"
  std::optional<Affine> parent_from_node;
  std::optional<bool> hidden;         ///< neither it nor what is below it is met by anything
  std::optional<std::uint32_t> mask;  ///< of it, and of what is below it without a mask of its own
  bool operator==(const NodeChange&) const = default;
};

/// One change for each node, ascending by node.
using NodeChanges = std::vector<NodeChange>;
/// `changes` as they are after `change` as well.
NodeChanges with_change(NodeChanges changes, const NodeChange& change);

/// Changes the nodes; what is below them moves and hides with them, by the importer's formulas.
/// Masks of instances are worked out anew. Returns the instances that are elsewhere, or hidden or
/// shown, ascending. Errors, and then the description is unusable: NODE_NOT_FOUND, NODE_POSES_SKIN
/// (a joint of a skin that is shown would move: its mesh would be another one), TRANSFORM_INVALID
/// (with its parents, or with a placement, a matrix holds more than a float32 can).
Result<std::vector<std::uint32_t>> change_nodes(SceneDescription& scene,
                                                std::span<const NodeChange> changes);
/// The mask that holds for each node.
std::vector<std::uint32_t> node_masks(const SceneDescription& scene);

}  // namespace sightline
