#pragma once
/// The structure of a glTF file, checked: types, ranges of references and required members need no
/// further checks. Lengths against real bytes, the graph of nodes and the values in accessors are
/// not checked yet.

#include <tiny_gltf.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/import/codec/meshopt_view.h"
#include "core/import/input/options.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// A buffer as the file states it; where its bytes are is found when they are first needed.
struct BufferEntry {
  std::uint64_t byte_length = 0;
  bool has_uri = false;
  std::string uri;
  bool fallback_only = false;  ///< EXT_meshopt_compression: no bytes, only a place for decoded ones
};

struct SkinEntry {
  std::vector<std::uint32_t> joints;         ///< indices in the file's "nodes"
  std::optional<std::size_t> inverse_binds;  ///< accessor; nothing: identities
};

/// KHR_draco_mesh_compression of a primitive.
struct DracoEntry {
  std::size_t view = 0;                             ///< bufferView of the compressed bytes
  std::map<std::string, std::uint32_t> attributes;  ///< ids of the attributes that rays need
};

inline constexpr std::array<const char*, kVertexAttributes> kVertexAttributeNames = {
    "NORMAL", "TEXCOORD_0", "COLOR_0"};

/// The bounds that an accessor states for its numbers: three of min and of max, or more or fewer,
/// or a min above its max. They are not trusted.
enum class StatedBounds : std::uint8_t { kNone, kOrdered, kCrossed };

/// The accessors of a primitive's attributes, by VertexAttribute.
struct AttributeEntry {
  std::array<int, kVertexAttributes> accessor = {-1, -1, -1};         ///< -1: none, or a wrong one
  std::array<std::optional<std::uint32_t>, kVertexAttributes> draco;  ///< ids of compressed ones
  /// One for each morph target: bit i says that it moves VertexAttribute i.
  std::vector<std::uint8_t> moved_by;
};

struct GltfDocument {
  /// Nodes, meshes, accessors and bufferViews, and the requested scene alone.
  /// Everything that rays do not need was erased before: images, textures, materials, animations,
  /// cameras, extras, bounds of accessors, attributes that move no position. `attributes` names
  /// some of those.
  tinygltf::Model model;
  std::vector<BufferEntry> buffers;
  std::vector<StatedBounds> stated_bounds;                          ///< by accessor
  std::map<std::size_t, MeshoptView> meshopt;                       ///< by bufferView
  std::map<std::pair<std::size_t, std::size_t>, DracoEntry> draco;  ///< by mesh and primitive
  std::map<std::pair<std::size_t, std::size_t>, AttributeEntry> attributes;  ///< likewise
  std::vector<Material> materials;
  std::vector<SkinEntry> skins;
  std::vector<std::optional<Camera>> cameras;         ///< what is wrong with one is a warning
  std::map<std::size_t, std::size_t> camera_of_node;  ///< both in range
  std::map<std::size_t, std::uint32_t> masks;         ///< by node: extras.sightline.mask
  bool has_scene = false;       ///< false: the file names none, every root node is loaded
  bool draco_required = false;  ///< KHR_draco_mesh_compression is required, there is no fallback
  bool quantization = false;    ///< KHR_mesh_quantization is used or required

  static bool has_view(const tinygltf::Accessor& accessor) { return accessor.bufferView >= 0; }

  /// Scenes, images, animations and attributes that were erased. Nodes and meshes are counted where
  /// they are traversed.
  ImportSkips skipped;
  std::vector<std::string> image_uris;  ///< only when nothing is to be skipped

  std::vector<std::string> warnings;
};

/// Guards, parses, thins and checks the JSON, and fills the model from what is left.
/// Errors: GLTF_JSON_*, GLTF_LIMIT_*, GLTF_VALUE_INVALID, GLTF_REFERENCE_INVALID,
/// GLTF_VERSION_UNSUPPORTED, GLTF_EXTENSION_UNSUPPORTED, GLTF_SCENE_UNKNOWN. Throws what nlohmann and the allocator throw.
Result<GltfDocument> read_document(std::string_view json, const ImportOptions& options);

inline constexpr const char* kQuantization = "KHR_mesh_quantization";
inline constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

}  // namespace sightline::gltf
