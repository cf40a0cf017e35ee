#include "core/import/gltf/hierarchy.h"

#include <cstdint>

#include "core/import/gltf/transform.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

constexpr std::uint32_t kNoNode = 0xffffffffu;

std::string name_of(std::size_t node) { return "node " + std::to_string(node); }

Error broken(const std::string& message, std::size_t node) {
  return invalid("GLTF_HIERARCHY_INVALID", message, "/nodes/" + std::to_string(node));
}

/// The parent of every node of the file, or kNoNode.
Result<std::vector<std::uint32_t>> find_parents(const std::vector<tinygltf::Node>& nodes) {
  std::vector<std::uint32_t> parents(nodes.size(), kNoNode);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (int child : nodes[i].children) {
      std::uint32_t& parent = parents[static_cast<std::size_t>(child)];
      if (parent != kNoNode) {
        return broken("node " + std::to_string(child) + " is listed as a child of " +
                          name_of(parent) + " and of " + name_of(i),
                      i);
      }
      parent = static_cast<std::uint32_t>(i);
    }
  }
  return parents;
}

/// With one parent at most, a node that no root leads to is on a cycle or below one.
Status check_cycles(const std::vector<tinygltf::Node>& nodes,
                    const std::vector<std::uint32_t>& parents) {
  std::vector<bool> reached(nodes.size(), false);
  std::vector<std::uint32_t> waiting;
  for (std::uint32_t root = 0; root < nodes.size(); ++root) {
    if (parents[root] != kNoNode) continue;
    waiting.push_back(root);
    while (!waiting.empty()) {
      const std::uint32_t node = waiting.back();
      waiting.pop_back();
      reached[node] = true;
      for (int child : nodes[node].children) waiting.push_back(static_cast<std::uint32_t>(child));
    }
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!reached[i]) return broken(name_of(i) + " is its own ancestor or below such a node", i);
  }
  return success();
}

/// The roots to load, in order.
Result<std::vector<std::uint32_t>> find_roots(const GltfDocument& document,
                                              const std::vector<std::uint32_t>& parents) {
  std::vector<std::uint32_t> roots;
  if (!document.has_scene) {
    for (std::uint32_t i = 0; i < parents.size(); ++i) {
      if (parents[i] == kNoNode) roots.push_back(i);
    }
    return roots;
  }
  std::vector<bool> listed(parents.size(), false);
  for (int root : document.model.scenes[0].nodes) {
    const auto node = static_cast<std::uint32_t>(root);
    if (parents[node] != kNoNode) {
      return broken("the scene lists " + name_of(node) + " as a root, it is a child of " +
                        name_of(parents[node]),
                    node);
    }
    if (listed[node]) return broken("the scene lists " + name_of(node) + " twice", node);
    listed[node] = true;
    roots.push_back(node);
  }
  return roots;
}

struct Visit {
  std::uint32_t node;
  std::uint32_t parent;  ///< index in the result
  std::uint32_t depth;
};

}  // namespace

Result<std::vector<Node>> walk_scene(const GltfDocument& document, const ImportLimits& limits,
                                     Warnings& warnings) {
  const auto& nodes = document.model.nodes;
  auto parents = find_parents(nodes);
  if (!parents) return parents.error();
  if (Status status = check_cycles(nodes, *parents); !status) return status.error();
  auto roots = find_roots(document, *parents);
  if (!roots) return roots.error();

  std::vector<Node> walked;
  std::vector<Visit> waiting;
  for (auto root = roots->rbegin(); root != roots->rend(); ++root) {
    waiting.push_back({*root, kNoNode, 1});
  }
  while (!waiting.empty()) {
    const Visit visit = waiting.back();
    waiting.pop_back();
    if (visit.depth > limits.node_depth) {
      return beyond_limit("NODE_DEPTH", name_of(visit.node) + ": depth below its root", visit.depth,
                          limits.node_depth, "/nodes/" + std::to_string(visit.node));
    }
    const tinygltf::Node& source = nodes[visit.node];
    std::string warning;
    auto local = node_matrix(source, visit.node, warning);
    if (!local) return local.error();
    if (!warning.empty()) warnings.add(std::move(warning));

    Node node;
    node.name = source.name;
    node.file_node = visit.node;
    node.parent = visit.parent;
    node.parent_from_node = *local;
    if (const auto mask = document.masks.find(visit.node); mask != document.masks.end()) {
      node.mask = mask->second;
    }
    node.world_from_node =
        visit.parent == kNoNode ? *local : walked[visit.parent].world_from_node * *local;
    if (!is_in_range(node.world_from_node)) {
      return invalid("GLTF_TRANSFORM_INVALID",
                     name_of(visit.node) +
                         ": with its parents, its matrix holds more than a "
                         "float32 can hold",
                     "/nodes/" + std::to_string(visit.node));
    }
    const auto index = static_cast<std::uint32_t>(walked.size());
    walked.push_back(std::move(node));
    for (auto child = source.children.rbegin(); child != source.children.rend(); ++child) {
      waiting.push_back({static_cast<std::uint32_t>(*child), index, visit.depth + 1});
    }
  }
  return walked;
}

}  // namespace sightline::gltf
