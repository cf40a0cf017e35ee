#pragma once
/// A demo mesh as the builder sees it.

#include <cstdint>
#include <vector>

#include "core/bvh/scene_tree.h"
#include "core/demo/demo.h"

namespace sightline {

struct TestMesh {
  std::vector<Vec3f> positions;
  std::vector<std::uint32_t> indices;

  explicit TestMesh(const demo::DemoMesh& mesh)
      : indices(mesh.indices.begin(), mesh.indices.end()) {
    for (std::size_t i = 0; i + 2 < mesh.positions.size(); i += 3) {
      positions.push_back({mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2]});
    }
  }
  MeshView view() const { return {positions, indices}; }
};

}  // namespace sightline
