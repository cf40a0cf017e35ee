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

/// A change of a node. An empty member changes nothing.
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

/// Changes the nodes. Nodes below them move and hide with them, by the importer's formulas. Masks
/// of instances are computed again. Returns the instances that moved, were hidden or were shown,
/// ascending. Errors, after which the description must not be used: NODE_NOT_FOUND, NODE_POSES_SKIN
/// (a joint of a visible skin would move), TRANSFORM_INVALID (a matrix, alone or with its parents
/// or a placement, exceeds float32).
Result<std::vector<std::uint32_t>> change_nodes(SceneDescription& scene,
                                                std::span<const NodeChange> changes);
/// The mask that holds for each node.
std::vector<std::uint32_t> node_masks(const SceneDescription& scene);

}  // namespace sightline

// Tests: tests/unit/run/moved_test.cpp
