#include "core/scene/node_changes.h"

#include <algorithm>
#include <string>
#include <unordered_map>

#include "core/scene/node_transform.h"

namespace sightline {

namespace {

constexpr std::uint32_t kNoParent = 0xffffffffu;

std::string name_of(const Node& node) { return "node " + std::to_string(node.file_node); }

Error out_of_range(const Node& node) {
  return {ErrorKind::kInvalid, "TRANSFORM_INVALID",
          name_of(node) + ": its matrix in the world would hold more than a float32 can hold", ""};
}

/// Nodes whose own transform is another one.
Result<std::vector<bool>> take_changes(SceneDescription& scene,
                                       std::span<const NodeChange> changes) {
  std::unordered_map<std::uint32_t, std::size_t> by_file;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) by_file[scene.nodes[i].file_node] = i;
  std::vector<bool> moved(scene.nodes.size());
  for (const NodeChange& change : changes) {
    const auto found = by_file.find(change.node);
    if (found == by_file.end()) {
      return Error{ErrorKind::kNotFound, "NODE_NOT_FOUND",
                   "the loaded scene has no node " + std::to_string(change.node),
                   "/nodes/" + std::to_string(&change - changes.data())};
    }
    Node& node = scene.nodes[found->second];
    if (change.hidden) node.hidden = *change.hidden;
    if (change.mask) node.mask = change.mask;
    if (!change.parent_from_node || *change.parent_from_node == node.parent_from_node) continue;
    node.parent_from_node = *change.parent_from_node;
    moved[found->second] = true;
  }
  return moved;
}

}  // namespace

std::vector<std::uint32_t> node_masks(const SceneDescription& scene) {
  std::vector<std::uint32_t> masks;
  masks.reserve(scene.nodes.size());
  for (const Node& node : scene.nodes) {
    const std::uint32_t above = node.parent == kNoParent ? 0xffffffffu : masks[node.parent];
    masks.push_back(node.mask.value_or(above));
  }
  return masks;
}

NodeChanges with_changes(NodeChanges changes, std::span<const NodeChange> more) {
  changes.insert(changes.end(), more.begin(), more.end());
  std::stable_sort(changes.begin(), changes.end(),
                   [](const NodeChange& a, const NodeChange& b) { return a.node < b.node; });
  NodeChanges merged;
  merged.reserve(changes.size());
  for (NodeChange& change : changes) {
    if (merged.empty() || merged.back().node != change.node) {
      merged.push_back(change);
      continue;
    }
    NodeChange& at = merged.back();
    if (change.parent_from_node) at.parent_from_node = change.parent_from_node;
    if (change.hidden) at.hidden = change.hidden;
    if (change.mask) at.mask = change.mask;
  }
  return merged;
}

Result<std::vector<std::uint32_t>> change_nodes(SceneDescription& scene,
                                                std::span<const NodeChange> changes) {
  auto taken = take_changes(scene, changes);
  if (!taken) return std::move(taken).error();
  std::vector<bool>& moved = *taken;
  std::vector<bool> hidden(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    // Parents stand before their children.
    Node& node = scene.nodes[i];
    const bool is_root = node.parent == kNoParent;
    hidden[i] = node.hidden || (!is_root && hidden[node.parent]);
    if (!is_root && moved[node.parent]) moved[i] = true;
    if (!moved[i]) continue;
    if (node.is_joint) {
      return Error{ErrorKind::kConflict, "NODE_POSES_SKIN",
                   name_of(node) + " is a joint of a skin, and would move: send the file anew", ""};
    }
    node.world_from_node = is_root
                               ? node.parent_from_node
                               : scene.nodes[node.parent].world_from_node * node.parent_from_node;
    if (!is_in_range(node.world_from_node)) return out_of_range(node);
  }
  const std::vector<std::uint32_t> masks = node_masks(scene);
  std::vector<std::uint32_t> changed;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    Instance& instance = scene.instances[i];
    const Affine before = instance.world_from_mesh;
    const Node& node = scene.nodes[instance.node];
    if (moved[instance.node] && !instance.posed) {
      const bool alone = instance.placement >= scene.placements.size();
      instance.world_from_mesh = alone
                                     ? node.world_from_node
                                     : node.world_from_node * scene.placements[instance.placement];
      if (!is_in_range(instance.world_from_mesh)) return out_of_range(node);
    }
    const bool is_hidden = hidden[instance.node];
    if (is_hidden != instance.hidden || instance.world_from_mesh != before) changed.push_back(i);
    instance.hidden = is_hidden;
    instance.mask = masks[instance.node];
  }
  return changed;
}

}  // namespace sightline
