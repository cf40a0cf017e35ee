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

/// [glTF2] 3.9.4. No answer depends on it.
enum class AlphaMode : std::uint8_t { kOpaque, kMask, kBlend };
/// "OPAQUE", "MASK", "BLEND", as files write it.
constexpr const char* alpha_mode_name(AlphaMode mode) {
  return mode == AlphaMode::kOpaque ? "OPAQUE" : mode == AlphaMode::kMask ? "MASK" : "BLEND";
}

struct Material {
  std::string name;
  bool double_sided = false;
  AlphaMode alpha_mode = AlphaMode::kOpaque;
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

/// Bytes of the files that were read, by what they are.
struct TouchedBytes {
  std::uint64_t json = 0;  ///< of a .pov file its text
  std::uint64_t positions = 0;
  std::uint64_t indices = 0;
  std::uint64_t poses = 0;       ///< morph targets, joints, weights and inverse bind matrices
  std::uint64_t placements = 0;  ///< EXT_mesh_gpu_instancing
  std::uint64_t compressed = 0;  ///< by EXT_meshopt_compression or KHR_draco_mesh_compression
  std::uint64_t others = 0;      ///< what no ray needs; 0 unless nothing was to be skipped

  std::uint64_t total() const {
    return json + positions + indices + poses + placements + compressed + others;
  }
};

/// What the files have and the import did not look at.
struct ImportSkips {
  std::uint64_t scenes = 0;
  std::uint64_t nodes = 0;   ///< that the loaded scene does not reach
  std::uint64_t meshes = 0;  ///< that no node of the loaded scene shows
  std::uint64_t images = 0;
  std::uint64_t animations = 0;
  std::uint64_t attributes = 0;  ///< of primitives: normals, texture coordinates, colours, ...
};

/// Counts of what a ray cannot meet, so that nothing disappears in silence.
struct ImportCounts {
  std::uint64_t skipped_primitives = 0;   ///< points, lines, and primitives without positions
  std::uint64_t nonfinite_triangles = 0;  ///< in mesh space, each mesh counted once
  /// The corners lie on one line, exactly, in mesh space; each mesh counted once.
  std::uint64_t degenerate_triangles = 0;
  std::uint64_t file_bytes = 0;     ///< of the file and the external buffers that were opened
  std::uint64_t bytes_touched = 0;  ///< touched.total()
  TouchedBytes touched;
  ImportSkips skipped;
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
