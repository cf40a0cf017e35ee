#include "server/service/node_search.h"

#include <algorithm>
#include <array>
#include <span>

#include "core/query/hit_filter.h"
#include "proto/json/json_parts.h"
#include "server/service/answer_memory.h"

namespace sightline {
namespace {

/// The materials of a node's own triangles, each once, in ascending order; the last may be kNone.
std::vector<std::uint32_t> materials_of(const SceneDescription& scene, std::uint32_t node) {
  std::vector<std::uint32_t> materials;
  const std::span<const Instance> instances = instances_of(std::span(scene.instances), node);
  if (instances.empty()) return materials;
  // All instances of a node have one mesh.
  for (const Primitive& part : scene.meshes[instances.front().mesh]->primitives) {
    materials.push_back(part.material);
  }
  std::sort(materials.begin(), materials.end());
  materials.erase(std::unique(materials.begin(), materials.end()), materials.end());
  return materials;
}

std::string_view material_name(const SceneDescription& scene, std::uint32_t material) {
  return material < scene.materials.size() ? std::string_view(scene.materials[material].name)
                                           : std::string_view();
}

bool matches(const SceneDescription& scene, const NodeQuery& query, std::uint32_t node,
             DeadlineWatch& watch) {
  if (query.name && !glob_matches(*query.name, scene.nodes[node].name, watch)) return false;
  if (query.instance && scene.instances[*query.instance].node != node) return false;
  if (query.material) {
    const auto materials = materials_of(scene, node);
    watch.passed(1 + materials.size());
    const bool found = std::any_of(materials.begin(), materials.end(), [&](std::uint32_t each) {
      return glob_matches(*query.material, material_name(scene, each), watch);
    });
    if (!found) return false;
  }
  if (!query.path) return true;
  const std::string path = node_path(scene, node);
  watch.passed(path.size());
  return glob_matches(*query.path, path, watch);
}

/// Counts of each node of a scene.
struct NodeCounts {
  explicit NodeCounts(const SceneDescription& scene)
      : children(scene.nodes.size()), triangles_below(scene.nodes.size()) {
    for (const Instance& each : scene.instances) {
      triangles_below[each.node] += scene.meshes[each.mesh]->triangle_count();
    }
    // Parents stand before their children.
    for (std::size_t i = scene.nodes.size(); i-- > 0;) {
      const std::uint32_t parent = scene.nodes[i].parent;
      if (parent == kNone || scene.nodes[i].removed) continue;
      ++children[parent];
      triangles_below[parent] += triangles_below[i];
    }
  }
  std::vector<std::uint32_t> children;
  std::vector<std::uint64_t> triangles_below;
};

void write_bounds(JsonWriter& out, const Box3d& bounds) {
  if (bounds.empty()) return out.raw("null");
  write(out, "{\"min\":", bounds.min, ",\"max\":", bounds.max, '}');
}

/// The extras of a node as JSON; "null" without.
std::string_view extras_of(const SceneDescription& scene, std::uint32_t node) {
  if (scene.extras == nullptr) return "null";
  const auto found = scene.extras->find(node);
  return found == scene.extras->end() ? std::string_view("null") : found->second;
}

void write_pose(JsonWriter& out, const Node& node) {
  out.raw(",\"matrix\":[");
  for (std::size_t column = 0; column < 4; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      write(out, column + row > 0 ? "," : "", node.parent_from_node.m[row][column]);
    }
    out.raw(column < 3 ? ",0" : ",1");
  }
  out.raw("],\"weights\":[");
  for (std::size_t i = 0; i < node.morph_targets; ++i) {
    const bool is_zero = node.weights == nullptr || i >= node.weights->size();
    write(out, i > 0 ? "," : "", is_zero ? 0.0 : (*node.weights)[i]);
  }
  out.raw(']');
}

void write_requested(JsonWriter& out, const SceneDescription& scene, const NodeQuery& query,
                     std::uint32_t node) {
  if (query.with_path) {
    out.raw(",\"path\":");
    out.string(node_path(scene, node));
  }
  if (query.with_materials) {
    out.raw(",\"materials\":[");
    bool is_first = true;
    for (const std::uint32_t each : materials_of(scene, node)) {
      if (!is_first) out.raw(',');
      is_first = false;
      out.name(material_name(scene, each));
    }
    out.raw(']');
  }
  if (query.with_extras) write(out, ",\"extras\":", extras_of(scene, node));
  if (query.with_pose) {
    const auto instances = instances_of(std::span(scene.instances), node);
    const std::size_t vertices =
        instances.empty() ? 0 : scene.meshes[instances.front().mesh]->positions.size();
    write_pose(out, scene.nodes[node]);
    write(out, ",\"vertices\":", static_cast<std::uint64_t>(vertices));
  }
}

}  // namespace

std::string node_path(const SceneDescription& scene, std::uint32_t node) {
  constexpr std::size_t kLongest = 4096;
  std::string path;
  for (; node != kNone; node = scene.nodes[node].parent) {
    const Node& its = scene.nodes[node];
    const std::string name = its.name.empty() ? "#" + std::to_string(its.file_node) : its.name;
    if (!path.empty() && path.size() + name.size() > kLongest) return "..." + path;
    path.insert(0, name).insert(0, "/");
  }
  return path;
}

Result<NodePage> find_nodes(const Scene& scene, const NodeQuery& query, DeadlineWatch& watch) {
  const SceneDescription& description = scene.description();
  NodePage page;
  for (std::uint32_t i = 0; i < description.nodes.size(); ++i) {
    const bool is_match = !description.nodes[i].removed && matches(description, query, i, watch);
    if (watch.passed()) return watch.error();
    if (!is_match) continue;
    if (page.total >= query.first && page.nodes.size() < query.limit) page.nodes.push_back(i);
    ++page.total;
  }
  return page;
}

std::uint64_t bytes_of_nodes(const Scene& scene, const NodeQuery& query, const NodePage& page) {
  constexpr std::uint64_t kNumbers = 640, kNumber = 26;
  const SceneDescription& description = scene.description();
  const auto text = [](std::string_view name) { return bytes_of_names(std::array{name}); };
  std::uint64_t bytes = 0;
  for (const std::uint32_t node : page.nodes) {
    bytes += kNumbers + text(description.nodes[node].name);
    if (query.with_path) bytes += text(node_path(description, node));
    if (query.with_extras) bytes += extras_of(description, node).size();
    if (query.with_pose)
      bytes += (16 + std::uint64_t{description.nodes[node].morph_targets}) * kNumber;
    if (!query.with_materials) continue;
    for (const std::uint32_t each : materials_of(description, node)) {
      bytes += text(material_name(description, each)) + 1;
    }
  }
  return bytes;
}

std::string encode_nodes(const Scene& scene, const NodeQuery& query, const NodePage& page) {
  const SceneDescription& description = scene.description();
  const NodeCounts counts(description);
  const std::vector<std::uint32_t> masks = node_masks(description);
  JsonWriter out(64 + page.nodes.size() * 256);
  write(out, "{\"total\":", page.total, ",\"nodes\":[");
  for (std::size_t i = 0; i < page.nodes.size(); ++i) {
    const std::uint32_t number = page.nodes[i];
    const Node& node = description.nodes[number];
    const std::span<const Instance> instances =
        instances_of(std::span(description.instances), number);
    const auto first = static_cast<std::uint32_t>(instances.data() - description.instances.data());
    std::uint64_t triangles = 0;
    for (const Instance& instance : instances)
      triangles += description.meshes[instance.mesh]->triangle_count();
    const Box3d bounds = scene.trees().plan().exact_bounds(first, instances.size());
    write(out, i > 0 ? ",{\"node_id\":" : "{\"node_id\":", node.file_node, ",\"name\":");
    out.name(node.name);
    out.raw(",\"parent\":");
    write_id(out, node.parent == kNone ? kNone : description.nodes[node.parent].file_node);
    write(out, ",\"children\":", counts.children[number],
          ",\"instances\":", static_cast<std::uint64_t>(instances.size()), ",\"first_instance\":");
    write_id(out, instances.empty() ? kNone : first);
    write(out, ",\"triangles\":", triangles,
          ",\"triangles_below\":", counts.triangles_below[number], ",\"hidden\":", node.hidden,
          ",\"mask\":", masks[number], ",\"bounds\":");
    write_bounds(out, bounds);
    write_requested(out, description, query, number);
    out.raw('}');
  }
  out.raw(']');
  const std::uint64_t end = query.first + page.nodes.size();
  if (end < page.total && query.first < page.total) write(out, ",\"next\":", end);
  out.raw("}\n");
  return out.take();
}

}  // namespace sightline
