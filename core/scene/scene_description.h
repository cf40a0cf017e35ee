#pragma once
/// What an importer hands over: everything a ray may need of one scene of a file, and what was left
/// out. Plain data, checked by the importer: every index in it is in range.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/geometry/affine.h"
#include "core/scene/mesh.h"

namespace sightline {

struct Material {
  std::string name;
  bool double_sided = false;
};

/// A node that is part of the loaded scene, in the order of a depth-first walk from the roots.
struct Node {
  std::string name;
  std::uint32_t file_node = 0;         ///< index in the file's "nodes"
  std::uint32_t parent = 0xffffffffu;  ///< index in SceneDescription::nodes
  Affine world_from_node;
};

/// One placement of a mesh. Instances stand in the order of the depth-first walk ("file order").
struct Instance {
  std::uint32_t mesh = 0;  ///< index in SceneDescription::meshes
  std::uint32_t node = 0;  ///< index in SceneDescription::nodes
  Affine world_from_mesh;
};

/// Counts of what a ray cannot meet, so that nothing disappears in silence.
struct ImportCounts {
  std::uint64_t skipped_primitives = 0;   ///< points, lines, and primitives without positions
  std::uint64_t nonfinite_triangles = 0;  ///< in mesh space, each mesh counted once
  std::uint64_t file_bytes = 0;
  std::uint64_t bytes_touched = 0;  ///< positions, indices and JSON that were read
};

struct SceneDescription {
  std::string name;
  std::vector<std::shared_ptr<const Mesh>> meshes;  ///< only meshes that an instance uses
  std::vector<Node> nodes;
  std::vector<Instance> instances;
  std::vector<Material> materials;
  std::vector<std::string> warnings;  ///< one sentence each, naming the place
  ImportCounts counts;
};

}  // namespace sightline
