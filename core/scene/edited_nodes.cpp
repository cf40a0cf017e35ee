#include "core/scene/edited_nodes.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/scene/edited_meshes.h"

namespace sightline {

namespace {

/// The number of nodes of the file, in the loaded scene or another one.
std::uint64_t nodes_of_file(const SceneDescription& scene) {
  const auto loaded = std::count_if(scene.nodes.begin(), scene.nodes.end(),
                                    [](const Node& node) { return !node.added; });
  return static_cast<std::uint64_t>(loaded) + scene.counts.skipped.nodes;
}

Status add_node(SceneDescription& scene, const NodeChange& change, const std::string& pointer,
                NodeNumbers& numbers) {
  const AddedNode& added = *change.added;
  const auto find = [&](std::uint32_t number) {
    const auto found = numbers.find(number);
    return found != numbers.end() && !scene.nodes[found->second].removed ? found : numbers.end();
  };
  const auto source = find(added.copy_of);
  if (source == numbers.end()) return no_such_node(added.copy_of, pointer + "/copy_of");
  if (Status status = check_unposed(scene, source->second, pointer + "/copy_of"); !status)
    return status;
  Node node;
  node.name = added.name;
  node.file_node = change.node;
  node.added = true;
  if (added.parent) {
    const auto parent = find(*added.parent);
    if (parent == numbers.end()) return no_such_node(*added.parent, pointer + "/parent");
    node.parent = parent->second;
  }
  const auto number = static_cast<std::uint32_t>(scene.nodes.size());
  const auto copied = instances_of(std::span(scene.instances), source->second);
  std::vector<Instance> instances(copied.begin(), copied.end());
  for (Instance& instance : instances) instance.node = number;
  scene.instances.insert(scene.instances.end(), instances.begin(), instances.end());
  scene.nodes.push_back(std::move(node));
  numbers[change.node] = number;
  return success();
}

/// The index of a mesh without triangles.
std::uint32_t empty_mesh(SceneDescription& scene, PosedMeshes& posed) {
  const auto found = std::find_if(scene.meshes.begin(), scene.meshes.end(),
                                  [](const auto& mesh) { return mesh->triangle_count() == 0; });
  const auto index = static_cast<std::uint32_t>(found - scene.meshes.begin());
  if (found == scene.meshes.end()) {
    scene.meshes.push_back(std::make_shared<const Mesh>());
    posed.fresh.push_back(index);
  }
  return index;
}

}  // namespace

NodeNumbers numbers_of(const SceneDescription& scene) {
  NodeNumbers numbers;
  numbers.reserve(scene.nodes.size());
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i) numbers[scene.nodes[i].file_node] = i;
  return numbers;
}

std::string pointer_of_change(std::size_t index, std::size_t sampled) {
  return "/nodes/" + std::to_string(index - std::min(index, sampled));
}

Error no_such_node(std::uint32_t number, std::string pointer) {
  return {ErrorKind::kNotFound, "NODE_NOT_FOUND",
          "the loaded scene has no node " + std::to_string(number), std::move(pointer)};
}

Status check_unposed(const SceneDescription& scene, std::uint32_t node,
                     const std::string& pointer) {
  const auto instances = instances_of(std::span(scene.instances), node);
  const std::string name = "node " + std::to_string(scene.nodes[node].file_node);
  if (instances.empty())
    return Error{ErrorKind::kInvalid, "NODE_MESHLESS", name + " has no triangles", pointer};
  if (!instances.front().posed && scene.nodes[node].morph_targets == 0) return success();
  return Error{ErrorKind::kInvalid, "NODE_POSED",
               name + " has a mesh that a skin or morph targets pose", pointer};
}

Status add_nodes(SceneDescription& scene, std::span<const NodeChange> changes, std::size_t sampled,
                 NodeNumbers& numbers) {
  const std::uint64_t of_file = nodes_of_file(scene);
  for (std::size_t i = sampled; i < changes.size(); ++i) {
    const NodeChange& change = changes[i];
    if (!change.added) continue;
    const std::string pointer = pointer_of_change(i, sampled);
    if (change.node > kLargestAddedNode) {
      return Error{ErrorKind::kInvalid, "NUMBER_OUT_OF_RANGE",
                   "the number of an added node is at most " + std::to_string(kLargestAddedNode),
                   pointer};
    }
    if (change.node < of_file || numbers.contains(change.node)) {
      return Error{ErrorKind::kConflict, "NODE_EXISTS",
                   "the number " + std::to_string(change.node) +
                       " is that of another node, of the file or removed",
                   pointer};
    }
    if (Status status = add_node(scene, change, pointer, numbers); !status) return status;
  }
  return success();
}

EditedSize size_after(const SceneDescription& scene, std::span<const NodeChange> changes) {
  EditedSize size{scene.nodes.size(), scene.instances.size()};
  const bool adds = std::any_of(changes.begin(), changes.end(),
                                [](const NodeChange& change) { return change.added.has_value(); });
  if (!adds) return size;
  const NodeNumbers numbers = numbers_of(scene);
  std::unordered_map<std::uint32_t, std::uint64_t> instances;  // of the added nodes
  for (const NodeChange& change : changes) {
    if (!change.added) continue;
    const std::uint32_t source = change.added->copy_of;
    const auto known = numbers.find(source);
    const std::uint64_t count = known != numbers.end()
                                    ? instances_of(std::span(scene.instances), known->second).size()
                                    : instances[source];
    instances[change.node] = count;
    ++size.nodes;
    size.instances += count;
  }
  return size;
}

void clear_removed_nodes(SceneDescription& scene, const HeldMeshes& held, PosedMeshes& posed) {
  const auto is_removed = [&](std::uint32_t node) { return scene.nodes[node].removed; };
  if (std::none_of(scene.nodes.begin(), scene.nodes.end(),
                   [](const Node& node) { return node.removed; }))
    return;
  std::vector<bool> is_shown = held;
  is_shown.resize(scene.meshes.size());
  for (const Instance& instance : scene.instances) {
    if (!is_removed(instance.node)) is_shown[instance.mesh] = true;
  }
  std::optional<std::uint32_t> empty;
  for (Instance& instance : scene.instances) {
    if (!is_removed(instance.node)) continue;
    if (scene.meshes[instance.mesh]->triangle_count() == 0) continue;
    if (is_shown[instance.mesh]) {
      if (!empty) empty = empty_mesh(scene, posed);
      instance.mesh = *empty;
    } else {
      scene.meshes[instance.mesh] = std::make_shared<const Mesh>();
      posed.fresh.push_back(instance.mesh);
    }
  }
  for (Node& node : scene.nodes) {
    if (node.removed) node.name.clear();
  }
  std::erase_if(scene.cameras, [&](const Camera& camera) { return is_removed(camera.node); });
  count_flat_triangles(scene);
}

}  // namespace sightline
