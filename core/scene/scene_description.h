#pragma once
/// SceneDescription: the result of an import. It has everything that rays need of one scene of a
/// file, and counts of what was left out. Plain data; the importer has checked that every index is
/// in range.

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/overflow_memory.h"
#include "core/geometry/affine.h"
#include "core/scene/alpha_texture.h"
#include "core/scene/mesh.h"

namespace sightline {

class Poser;

/// The transparency mode of a material [glTF2] 3.9.4. Answers do not depend on it.
enum class AlphaMode : std::uint8_t { kOpaque, kMask, kBlend };
/// "OPAQUE", "MASK" or "BLEND", as files write it.
constexpr const char* alpha_mode_name(AlphaMode mode) {
  return mode == AlphaMode::kOpaque ? "OPAQUE" : mode == AlphaMode::kMask ? "MASK" : "BLEND";
}

/// A material of the file, as far as answers name it.
struct Material {
  std::string name;
  bool double_sided = false;
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  std::array<double, 4> base_colour = {1, 1, 1, 1};  ///< linear red, green, blue and alpha
  bool transmits = false;     ///< KHR_materials_transmission with a factor above 0
  double alpha_cutoff = 0.5;  ///< of kMask
  /// Of kMask: the alpha of its base colour texture; null if it has none.
  std::shared_ptr<const AlphaTexture> alpha_texture = {};
};

/// A node of the loaded scene. Nodes are in the order of a depth-first walk from the roots; nodes
/// that clients added follow in the order of their additions. So a parent stands before its
/// children.
struct Node {
  std::string name;
  std::uint32_t file_node = 0;         ///< index in the file's "nodes", or chosen by the client
  std::uint32_t parent = 0xffffffffu;  ///< index in SceneDescription::nodes; 0xffffffff: a root
  Affine world_from_node = {};
  Affine parent_from_node = {};
  bool hidden = false;    ///< no ray meets the node and the nodes below it, whose own flag stays
  bool is_joint = false;  ///< a joint of a skin that the scene shows
  bool added = false;     ///< by a client: the file has no such node
  /// by a client, or below such a node: it has no name and no triangles, and no answer mentions it
  bool removed = false;
  std::uint32_t morph_targets = 0;  ///< of its mesh
  /// of its morph targets; those that are left out at the end, or all of null, are 0
  std::shared_ptr<const std::vector<double>> weights = {};
  /// A ray meets the node only if the mask of the ray shares a bit with this one. Empty: the
  /// parent's mask; for a root all bits.
  std::optional<std::uint32_t> mask = {};
};

/// A camera of the file, placed by a node [glTF2] 3.10. It points along -z of the node; y is up.
struct Camera {
  std::string name;
  std::uint32_t file_camera = 0;  ///< index in the file's "cameras"
  std::uint32_t node = 0;         ///< index in SceneDescription::nodes
  bool orthographic = false;
  double size_y = 0;  ///< yfov in radians, or ymag: half of the visible height in the node's units
  double near = 0, far = 0;  ///< znear and zfar; far is infinite if a perspective camera has none
};

/// A placement of a mesh. Instances are in the order of their nodes. Those of removed nodes stay, with
/// a mesh without triangles, so that no other number changes.
struct Instance {
  std::uint32_t mesh = 0;  ///< index in SceneDescription::meshes
  std::uint32_t node = 0;  ///< index in SceneDescription::nodes
  Affine world_from_mesh;
  /// If a node has several instances (EXT_mesh_gpu_instancing): index in
  /// SceneDescription::placements.
  std::uint32_t placement = 0xffffffffu;
  /// by a skin: the positions of its mesh are in world space, independent of its node
  bool posed = false;
  /// its node is hidden: no ray meets the instance, but it retains its number
  bool hidden = false;
  std::uint32_t mask = 0xffffffffu;  ///< the effective mask of its node
};

/// The instances of a node, which are consecutive: instances are in the order of their nodes. `all`
/// are SceneDescription::instances. Cost: logarithmic.
template <class AnInstance>
std::span<AnInstance> instances_of(std::span<AnInstance> all, std::uint32_t node) {
  const auto before = [](const Instance& each, std::uint32_t n) { return each.node < n; };
  const auto begin = std::lower_bound(all.begin(), all.end(), node, before);
  return {begin, std::lower_bound(begin, all.end(), node + 1, before)};
}

/// A vertex attribute that the file names, such as _TEMPERATURE.
struct NamedAttribute {
  std::string name;              ///< is_attribute_name (core/query/attribute_name.h) is true
  std::uint32_t components = 1;  ///< numbers for each vertex, 1 to 4
  bool is_in_scene = false;      ///< a primitive of the scene has a usable one
};

/// Counts of the bytes that an import read, by what they are.
struct TouchedBytes {
  std::uint64_t json = 0;  ///< JSON; for a .pov file its text
  std::uint64_t positions = 0;
  std::uint64_t indices = 0;
  std::uint64_t poses = 0;       ///< morph targets, joints, weights and inverse bind matrices
  std::uint64_t placements = 0;  ///< placements of EXT_mesh_gpu_instancing
  /// Normals, texture coordinates and colours that the import copied.
  std::uint64_t attributes = 0;
  /// bytes compressed by EXT_meshopt_compression or KHR_draco_mesh_compression
  std::uint64_t compressed = 0;
  std::uint64_t others = 0;  ///< bytes that no ray needs; 0 unless ImportOptions::skip is false

  std::uint64_t total() const {
    return json + positions + indices + poses + placements + attributes + compressed + others;
  }
};

/// Counts of what the files contain and the import did not read.
struct ImportSkips {
  std::uint64_t scenes = 0;
  std::uint64_t nodes = 0;   ///< nodes that are not in the loaded scene
  std::uint64_t meshes = 0;  ///< meshes that no node of the loaded scene shows
  std::uint64_t images = 0;
  std::uint64_t animations = 0;
  /// Attributes of primitives: normals, texture coordinates, colours, tangents, ... Hits may read
  /// some of them later.
  std::uint64_t attributes = 0;
};

/// Counts of what was left out or cannot be hit, so that nothing disappears without notice.
struct ImportCounts {
  std::uint64_t skipped_primitives = 0;   ///< points, lines, and primitives without positions
  std::uint64_t nonfinite_triangles = 0;  ///< in mesh space, each mesh counted once
  /// Triangles whose corners lie on one line, exactly, in mesh space; each mesh counted once. Such
  /// a triangle can still be hit if the rounded world corners of a placement do not lie on a line.
  std::uint64_t degenerate_triangles = 0;
  std::uint64_t file_bytes = 0;  ///< size of the file and of the external buffers that were opened
  std::uint64_t bytes_touched = 0;  ///< touched.total()
  std::uint64_t posed_meshes = 0;   ///< meshes that the last change of nodes gave another pose
  TouchedBytes touched;
  ImportSkips skipped;
};

/// The description of a scene.
struct SceneDescription {
  std::string name;
  /// Only meshes that an instance uses. Those of removed nodes have no triangles.
  std::vector<std::shared_ptr<const Mesh>> meshes;
  std::vector<Node> nodes;
  std::vector<Instance> instances;
  std::vector<Affine> placements;  ///< node_from_mesh of the instances with an index `placement`
  std::vector<Material> materials;
  std::vector<NamedAttribute> named_attributes;  ///< by VertexAttribute, from kNamed on
  std::vector<Camera> cameras;                   ///< in the order of nodes
  std::vector<std::string> warnings;             ///< one sentence each, naming the place
  std::shared_ptr<const Poser> poser;            ///< null: no pose of the scene can change
  /// By index in `nodes`: the JSON text of the node's extras. Null if no node has extras.
  std::shared_ptr<const std::map<std::uint32_t, std::string>> extras;
  ImportCounts counts;
  /// Positions and indices may be there, or in ordinary memory. Null: none are there.
  std::shared_ptr<OverflowMemory> overflow;
};

/// Bytes of positions, indices, copied vertex attributes, and what other poses need.
std::uint64_t geometry_bytes(const SceneDescription& scene);
/// Those of positions and indices that are in `overflow`.
std::uint64_t overflow_bytes(const SceneDescription& scene);

/// The attribute that the file names so; empty if it has none.
inline std::optional<VertexAttribute> find_named_attribute(const SceneDescription& scene,
                                                           std::string_view name) {
  for (std::size_t i = 0; i < scene.named_attributes.size(); ++i) {
    if (scene.named_attributes[i].name == name) return named_attribute(i);
  }
  return {};
}

}  // namespace sightline

// Tests: tests/unit/import/accessor_test.cpp
