#pragma once
/// What an import promises, whatever the bytes were.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/import/import.h"
#include "tests/fuzz/promise.h"

namespace sightline::fuzz {

/// Small enough that a hit of a limit is found by a small file, and that a run needs little memory.
inline ImportOptions small_limits() {
  ImportOptions options;
  options.limits.json_values = 100000;
  options.limits.triangles = 100000;
  options.limits.nodes = 10000;
  options.limits.instances = 10000;
  options.limits.geometry_bytes = 16u << 20;
  options.limits.zero_filled = 10000;
  options.copies_attributes = true;
  return options;
}

/// Calls visit(numbers, file's vertex) for what hits may ask of some of a mesh's triangles.
template <class Visit>
void each_attribute(const Mesh& mesh, const Visit& visit) {
  constexpr std::size_t kMost = 200;
  require(mesh.attributes.size() <= mesh.primitives.size(), "attributes are those of primitives");
  for (std::size_t k = 0; k < mesh.attributes.size(); ++k) {
    const Primitive& primitive = mesh.primitives[k];
    const std::size_t begin = std::size_t{primitive.first_triangle} * 3;
    const std::size_t corners = std::min<std::size_t>(primitive.triangle_count, kMost) * 3;
    for (const auto& [attribute, numbers] : mesh.attributes[k].entries) {
      for (std::size_t c = begin; c < begin + corners; ++c) {
        const std::uint32_t vertex = mesh.indices[c] + mesh.attributes[k].first_vertex;
        visit(k, attribute, *numbers, vertex);
      }
    }
  }
}

inline void check(const SceneDescription& scene) {
  for (const auto& mesh : scene.meshes) {
    require(mesh->indices.size() % 3 == 0, "three corners per triangle");
    for (std::uint32_t index : mesh->indices) {
      require(index < mesh->positions.size(), "corners are vertices");
    }
    std::uint32_t next = 0;
    for (const Primitive& primitive : mesh->primitives) {
      require(primitive.first_triangle == next, "primitives follow one another");
      next += primitive.triangle_count;
      require(primitive.material == 0xffffffffu || primitive.material < scene.materials.size(),
              "materials exist");
    }
    require(next == mesh->triangle_count() && next > 0, "primitives cover the mesh");
    each_attribute(*mesh, [](std::size_t, VertexAttribute, const VertexNumbers& numbers,
                             std::uint32_t vertex) {
      require(numbers.components() >= 1 && numbers.components() <= 4, "one to four numbers");
      double values[4];
      std::uint64_t touched = 0;
      numbers.load(vertex, values, touched);
    });
  }
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    require(scene.nodes[i].parent == 0xffffffffu || scene.nodes[i].parent < i,
            "parents stand before their children");
  }
  std::vector<bool> used(scene.meshes.size(), false);
  for (const Instance& instance : scene.instances) {
    require(instance.mesh < scene.meshes.size() && instance.node < scene.nodes.size(),
            "instances name a mesh and a node");
    used[instance.mesh] = true;
    for (const auto& row : instance.world_from_mesh.m) {
      for (double value : row) require(value - value == 0, "matrices are finite");
    }
  }
  for (bool is_used : used) require(is_used, "every mesh is placed");
}

/// A scene that keeps its promises, or an error with a code and a short message.
inline void check(const Result<SceneDescription>& scene) {
  if (scene) return check(*scene);
  require(!scene.error().code.empty() && scene.error().code != "GLTF_INTERNAL",
          "errors have a code");
  require(scene.error().message.size() < 1000, "messages do not echo the file");
}

}  // namespace sightline::fuzz
