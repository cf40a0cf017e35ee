#pragma once
/// The result of an import: everything that rays may need of one scene of a file, and counts of
/// what was left out. Plain data, checked by the importer: every index in it is in range.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
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
  std::array<double, 4> base_colour = {1, 1, 1, 1};  ///< linear red, green, blue and alpha
};

/// A node that is part of the loaded scene, in the order of a depth-first walk from the roots.
struct Node {
  std::string name;
  std::uint32_t file_node = 0;         ///< index in the file's "nodes"
  std::uint32_t parent = 0xffffffffu;  ///< index in SceneDescription::nodes
  Affine world_from_node = {};
  Affine parent_from_node = {};
  bool hidden = false;    ///< itself; what is below it is not met either
  bool is_joint = false;  ///< of a skin that the scene shows
  /// Which rays meet it: those with a bit in common. None: its parent's, all bits for a root.
  std::optional<std::uint32_t> mask = {};
};

/// A camera of the file, placed by a node [glTF2] 3.10. It points along -z of the node; y is up.
struct Camera {
  std::string name;
  std::uint32_t file_camera = 0;  ///< index in the file's "cameras"
  std::uint32_t node = 0;         ///< index in SceneDescription::nodes
  bool orthographic = false;
  double size_y = 0;  ///< yfov in radians, or ymag: half of what is seen, in the node's units
  double near = 0, far = 0;
};

/// One placement of a mesh. Instances stand in the order of the depth-first walk ("file order").
struct Instance {
  std::uint32_t mesh = 0;  ///< index in SceneDescription::meshes
  std::uint32_t node = 0;  ///< index in SceneDescription::nodes
  Affine world_from_mesh;
  /// Where one node has several (EXT_mesh_gpu_instancing), the index in
  /// SceneDescription::placements.
  std::uint32_t placement = 0xffffffffu;
  bool posed = false;   ///< by a skin: its mesh stands in the world, wherever its node is
  bool hidden = false;  ///< with its node: no ray meets it, but its number stays in use
  std::uint32_t mask = 0xffffffffu;  ///< of its node
};

/// Bytes of the files that were read, by what they are.
struct TouchedBytes {
  std::uint64_t json = 0;  ///< of a .pov file its text
  std::uint64_t positions = 0;
  std::uint64_t indices = 0;
  std::uint64_t poses = 0;       ///< morph targets, joints, weights and inverse bind matrices
  std::uint64_t placements = 0;  ///< EXT_mesh_gpu_instancing
  /// Normals, texture coordinates and colours that the import copied.
  std::uint64_t attributes = 0;
  std::uint64_t compressed = 0;  ///< by EXT_meshopt_compression or KHR_draco_mesh_compression
  std::uint64_t others = 0;      ///< what no ray needs; 0 unless nothing was to be skipped

  std::uint64_t total() const {
    return json + positions + indices + poses + placements + attributes + compressed + others;
  }
};

/// What the files contain and the import did not read.
struct ImportSkips {
  std::uint64_t scenes = 0;
  std::uint64_t nodes = 0;   ///< that the loaded scene does not reach
  std::uint64_t meshes = 0;  ///< that no node of the loaded scene shows
  std::uint64_t images = 0;
  std::uint64_t animations = 0;
  /// Attributes of primitives: normals, texture coordinates, colours, tangents, ... Hits may read
  /// some later.
  std::uint64_t attributes = 0;
};

/// Counts of what a ray cannot meet, so that nothing disappears in silence.
struct ImportCounts {
  std::uint64_t skipped_primitives = 0;   ///< points, lines, and primitives without positions
  std::uint64_t nonfinite_triangles = 0;  ///< in mesh space, each mesh counted once
  /// The corners lie on one line, exactly, in mesh space; each mesh counted once. A placement's
  /// rounded corners decide whether such a triangle is hit.
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
  std::vector<Affine> placements;  ///< node_from_mesh of instances that have one
  std::vector<Material> materials;
  std::vector<Camera> cameras;        ///< in the order of nodes
  std::vector<std::string> warnings;  ///< one sentence each, naming the place
  ImportCounts counts;
};

}  // namespace sightline

// Tests: tests/unit/import/accessor_test.cpp
