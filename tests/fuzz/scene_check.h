#pragma once
/// What an import promises, whatever the bytes were.

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
  return options;
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
