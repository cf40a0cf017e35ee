#include "core/scene/node_changes.h"

#include <algorithm>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "core/scene/edited_meshes.h"
#include "core/scene/edited_nodes.h"
#include "core/scene/node_transform.h"

namespace sightline {

namespace {

constexpr std::uint32_t kNoParent = 0xffffffffu;

std::string name_of(const Node& node) { return "node " + std::to_string(node.file_node); }

Error out_of_range(const Node& node) {
  return {ErrorKind::kInvalid, "TRANSFORM_INVALID",
          name_of(node) + ": its matrix in the world would hold more than a float32 can hold", ""};
}

/// Returns whether they are others. Errors: NODE_WEIGHTS_WRONG.
Result<bool> take_weights(Node& node, const std::vector<double>& weights,
                          const std::string& pointer) {
  const std::uint32_t count = node.morph_targets;
  if (weights.size() != count) {
    return Error{ErrorKind::kInvalid, "NODE_WEIGHTS_WRONG",
                 name_of(node) +
                     (count == 0 ? " has no morph targets"
                                 : " has " + std::to_string(count) + " morph targets, these are " +
                                       std::to_string(weights.size()) + " weights"),
                 pointer + "/weights"};
  }
  std::vector<double> before = node.weights ? *node.weights : std::vector<double>();
  before.resize(count);
  if (before == weights) return false;
  node.weights = std::make_shared<const std::vector<double>>(weights);
  return true;
}

/// Nodes whose own transform or weights are others. An animation also moves removed joints.
Result<PoseChange> take_changes(SceneDescription& scene, std::span<const NodeChange> changes,
                                std::size_t sampled, const NodeNumbers& numbers) {
  PoseChange taken{std::vector<bool>(scene.nodes.size()), std::vector<bool>(scene.nodes.size())};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const NodeChange& change = changes[i];
    const std::string pointer = pointer_of_change(i, sampled);
    const auto found = numbers.find(change.node);
    if (found == numbers.end() || (i >= sampled && scene.nodes[found->second].removed))
      return no_such_node(change.node, pointer);
    Node& node = scene.nodes[found->second];
    if (change.added) taken.moved[found->second] = true;
    if (!change.weights.empty()) {
      const auto weighted = take_weights(node, change.weights, pointer);
      if (!weighted) return weighted.error();
      if (*weighted) taken.weighted[found->second] = true;
    }
    if (change.hidden) node.hidden = *change.hidden;
    if (change.mask) node.mask = change.mask;
    if (!change.parent_from_node || *change.parent_from_node == node.parent_from_node) continue;
    node.parent_from_node = *change.parent_from_node;
    taken.moved[found->second] = true;
  }
  return taken;
}

/// Gives each added node the positions that the node that it copies has by an earlier change of the
/// list or of the scene. So they stay its own, whatever happens to that node later.
void take_copied_positions(const SceneDescription& scene, std::span<NodeChange> changes) {
  if (std::none_of(changes.begin(), changes.end(),
                   [](const NodeChange& change) { return change.added.has_value(); }))
    return;
  const NodeNumbers numbers = numbers_of(scene);
  std::unordered_map<std::uint32_t, SharedColumn<Vec3f>> set;
  for (NodeChange& change : changes) {
    if (change.added && change.positions.empty()) {
      const std::uint32_t source = change.added->copy_of;
      const auto known = numbers.find(source);
      if (const auto earlier = set.find(source); earlier != set.end()) {
        change.positions = earlier->second;
      } else if (known != numbers.end()) {
        const auto instances = instances_of(std::span(scene.instances), known->second);
        if (!instances.empty() && scene.meshes[instances.front().mesh]->edited != 0)
          change.positions = scene.meshes[instances.front().mesh]->positions;
      }
    }
    if (!change.positions.empty()) set[change.node] = change.positions;
  }
}

/// True if the changes give a mesh another pose.
bool poses(const SceneDescription& scene, const PoseChange& change) {
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (change.weighted[i] || (change.moved[i] && scene.nodes[i].is_joint)) return true;
  }
  return false;
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
  NodeChanges merged;
  merged.reserve(changes.size());
  std::unordered_map<std::uint32_t, std::size_t> place;
  for (NodeChange& change : changes) {
    const auto [known, is_new] = place.try_emplace(change.node, merged.size());
    if (is_new) {
      merged.push_back(std::move(change));
      continue;
    }
    NodeChange& at = merged[known->second];
    at.removed = at.removed || change.removed;
    if (change.parent_from_node) at.parent_from_node = change.parent_from_node;
    if (change.hidden) at.hidden = change.hidden;
    if (change.mask) at.mask = change.mask;
    if (!change.weights.empty()) at.weights = std::move(change.weights);
    if (!change.positions.empty()) at.positions = std::move(change.positions);
  }
  std::stable_sort(merged.begin(), merged.end(), [](const NodeChange& a, const NodeChange& b) {
    if (a.added || b.added) return !a.added && b.added;
    return a.node < b.node;
  });
  return merged;
}

bool may_pose(const SceneDescription& scene, const SceneChange& change) {
  if (change.animation) return true;
  std::unordered_set<std::uint32_t> changed;
  for (const NodeChange& each : change.nodes) {
    if (!each.weights.empty()) return true;
    if (each.parent_from_node) changed.insert(each.node);
  }
  if (changed.empty()) return false;
  std::vector<bool> moves(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    moves[i] = changed.contains(node.file_node) || (node.parent != kNoParent && moves[node.parent]);
    if (moves[i] && node.is_joint) return true;
  }
  return false;
}

Result<ResolvedChange> resolve(const SceneDescription& scene, const SceneChange& change) {
  ResolvedChange resolved;
  if (change.animation) {
    if (scene.poser == nullptr) {
      return Error{ErrorKind::kInvalid, "ANIMATION_UNKNOWN", "the scene has no animations",
                   "/animation"};
    }
    auto sampled = scene.poser->sample(*change.animation);
    if (!sampled) return std::move(sampled).error();
    resolved.nodes = *std::move(sampled);
    resolved.sampled = resolved.nodes.size();
  }
  resolved.nodes.insert(resolved.nodes.end(), change.nodes.begin(), change.nodes.end());
  take_copied_positions(scene, std::span(resolved.nodes).subspan(resolved.sampled));
  return resolved;
}

void forget_removed(const SceneDescription& scene, NodeChanges& changes) {
  std::unordered_set<std::uint32_t> removed;
  for (const Node& node : scene.nodes) {
    if (node.removed) removed.insert(node.file_node);
  }
  for (NodeChange& change : changes) {
    if (!removed.contains(change.node)) continue;
    change.positions = {};
    change.hidden.reset();
    change.mask.reset();
    // Nodes of the file may be above joints, which still pose a skin.
    if (!change.added) continue;
    change.added->name.clear();
    change.parent_from_node.reset();
  }
}

Result<ChangedInstances> change_nodes(SceneDescription& scene, std::span<const NodeChange> changes,
                                      std::size_t sampled, const HeldMeshes& held) {
  const std::size_t old_instances = scene.instances.size();
  NodeNumbers numbers = numbers_of(scene);
  if (Status status = add_nodes(scene, changes, sampled, numbers); !status)
    return std::move(status).error();
  auto taken = take_changes(scene, changes, sampled, numbers);
  if (!taken) return std::move(taken).error();
  for (const NodeChange& change : changes) {
    if (change.removed) scene.nodes[numbers.at(change.node)].removed = true;
  }
  std::vector<bool>& moved = taken->moved;
  std::vector<bool> hidden(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    // Parents stand before their children.
    Node& node = scene.nodes[i];
    const bool is_root = node.parent == kNoParent;
    node.removed = node.removed || (!is_root && scene.nodes[node.parent].removed);
    hidden[i] = node.hidden || node.removed || (!is_root && hidden[node.parent]);
    if (!is_root && moved[node.parent]) moved[i] = true;
    if (!moved[i]) continue;
    node.world_from_node = is_root
                               ? node.parent_from_node
                               : scene.nodes[node.parent].world_from_node * node.parent_from_node;
    if (!is_in_range(node.world_from_node)) return out_of_range(node);
  }
  ChangedInstances result;
  if (poses(scene, *taken)) {
    if (scene.poser == nullptr) {
      return Error{ErrorKind::kConflict, "NODE_POSES_SKIN",
                   "a mesh would have another pose, and the scene was loaded without what poses it",
                   ""};
    }
    auto posed = scene.poser->pose(scene, *taken);
    if (!posed) return std::move(posed).error();
    result.posed = *std::move(posed);
  }
  if (Status status = set_positions(scene, changes, sampled, numbers, held, result.posed); !status)
    return std::move(status).error();
  clear_removed_nodes(scene, held, result.posed);
  std::vector<std::uint32_t>& fresh = result.posed.fresh;
  std::sort(fresh.begin(), fresh.end());
  fresh.erase(std::unique(fresh.begin(), fresh.end()), fresh.end());
  std::vector<bool> is_posed(scene.instances.size());
  for (const std::uint32_t i : result.posed.instances) is_posed[i] = true;
  const std::vector<std::uint32_t> masks = node_masks(scene);
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
    const bool is_new = i >= old_instances;
    if (is_new || is_posed[i] || is_hidden != instance.hidden || instance.world_from_mesh != before)
      result.instances.push_back(i);
    instance.hidden = is_hidden;
    instance.mask = node.removed ? 0xffffffffu : masks[instance.node];
  }
  return result;
}

}  // namespace sightline
