#pragma once
/// Changes of nodes that clients made after the file was loaded.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// A change of a node by a client. An empty member changes nothing.
struct NodeChange {
  std::uint32_t node = 0;                  ///< index in the file's "nodes"
  std::optional<Affine> parent_from_node;  ///< replaces the node's matrix
  std::optional<bool> hidden;              ///< true: no ray meets the node or the nodes below it
  /// mask of the node, and of the nodes below it that have none of their own
  std::optional<std::uint32_t> mask;
  bool operator==(const NodeChange&) const = default;
};

/// All changes of a scene: one for each changed node, ascending by node.
using NodeChanges = std::vector<NodeChange>;
/// Returns `changes` with the changes of `more` added in order: members of a change that have a
/// value replace those of the earlier change of its node, if there is one.
NodeChanges with_changes(NodeChanges changes, std::span<const NodeChange> more);

/// Applies changes to the nodes of a scene description. Nodes below a changed node move and hide
/// with it, by the importer's formulas. Masks of instances are computed again. Returns the
/// instances that moved, were hidden or were shown, ascending. Errors: NODE_NOT_FOUND, with the
/// pointer /nodes/N of change N; NODE_POSES_SKIN (a joint of a visible skin would move);
/// TRANSFORM_INVALID (a matrix, alone or multiplied by those of its parents or a placement, exceeds
/// float32). After an error the description must not be used.
Result<std::vector<std::uint32_t>> change_nodes(SceneDescription& scene,
                                                std::span<const NodeChange> changes);
/// Returns the effective mask of each node: its own, or that of its nearest parent with a mask, or
/// all bits.
std::vector<std::uint32_t> node_masks(const SceneDescription& scene);

}  // namespace sightline

// Tests: tests/unit/run/moved_test.cpp
