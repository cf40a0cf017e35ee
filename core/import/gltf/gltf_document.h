#pragma once
/// GltfDocument: the structure of a glTF file after checks. Valid are the types of members, the
/// ranges of references (indices of other elements), and that required members are present. Not yet
/// checked are lengths against real bytes, the graph of nodes, and the values in accessors.

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

/// A buffer as the file states it. BufferStore finds its bytes when they are first needed.
struct BufferEntry {
  std::uint64_t byte_length = 0;
  bool has_uri = false;
  std::string uri;  ///< as in the file: a data URI or a relative reference
  /// EXT_meshopt_compression: the buffer has no bytes; compressed views refer to it
  bool fallback_only = false;
};

/// A skin.
struct SkinEntry {
  std::vector<std::uint32_t> joints;         ///< indices of nodes in the file
  std::optional<std::size_t> inverse_binds;  ///< accessor; empty: all matrices are the identity
};

/// The extension KHR_draco_mesh_compression of a primitive.
struct DracoEntry {
  std::size_t view = 0;  ///< bufferView of the compressed bytes
  /// by name of the attribute: its id in the compressed bytes, for attributes that rays need
  std::map<std::string, std::uint32_t> attributes;
};

/// The names in files, by VertexAttribute, below kNamed.
inline constexpr std::array<const char*, 5> kVertexAttributeNames = {
    "NORMAL", "TEXCOORD_0", "COLOR_0", "TEXCOORD_1", "TANGENT"};

/// A vertex attribute that the file names.
struct NamedEntry {
  std::string name;
  std::size_t accessor = 0;  ///< of its first primitive in the file; others must be of its type
};
/// The vertex attributes that the file names, in the order of their first primitives.
struct NamedEntries {
  static constexpr std::size_t kMost = 256;  ///< names; others are left out
  std::vector<NamedEntry> list;              ///< by VertexAttribute, from kNamed on
  std::map<std::string, VertexAttribute> by_name;
  std::uint64_t left_out = 0;  ///< attributes of primitives whose names are no fields, or too many
  std::string example;         ///< the name of the first of them, shortened
};

/// What an accessor states as min and max of its numbers: nothing usable (kNone), three of each
/// with min <= max (kOrdered), or a min above its max (kCrossed). The values are not trusted.
enum class StatedBounds : std::uint8_t { kNone, kOrdered, kCrossed };

/// The accessor of a vertex attribute of a primitive.
struct AttributeEntry {
  VertexAttribute attribute = VertexAttribute::kNormal;
  int accessor = 0;
  std::optional<std::uint32_t> draco = {};  ///< id in the Draco bytes, if compressed
  static constexpr int kUnusable = -2;
  /// For each morph target: the accessor of what it adds to the attribute. -1: nothing; kUnusable:
  /// its reference is invalid.
  std::vector<int> targets = {};
};

/// The alpha of a masked material: its cutoff, and how its base colour texture is read.
struct AlphaEntry {
  enum class Wrap : std::uint8_t { kRepeat, kClamp, kMirror };
  double cutoff = 0.5;
  bool has_texture = false;
  std::string problem;   ///< why the texture cannot be used; empty: it can
  std::size_t view = 0;  ///< bufferView of the image
  std::array<Wrap, 2> wrap{};
  std::array<double, 2> offset{0, 0}, scale{1, 1};
};

/// What a channel of an animation changes of its node.
enum class AnimationPath : std::uint8_t { kTranslation, kRotation, kScale, kWeights };
/// How values between two keys are computed [glTF2] appendix C.
enum class Interpolation : std::uint8_t { kLinear, kStep, kCubicSpline };

/// A sampler of an animation: accessors of times and of values.
struct AnimationSamplerEntry {
  std::uint32_t input = 0, output = 0;
  Interpolation interpolation = Interpolation::kLinear;
};
/// A channel of an animation.
struct AnimationChannel {
  std::uint32_t node = 0;  ///< index in the file
  AnimationPath path = AnimationPath::kTranslation;
  std::uint32_t sampler = 0;
};
/// An animation. All indices are in range.
struct AnimationEntry {
  std::string name;
  std::vector<AnimationSamplerEntry> samplers;
  std::vector<AnimationChannel> channels;  ///< those that target a node, ascending by node and path
  std::string problem;                     ///< why it cannot be sampled; empty: nothing is known
};

/// A checked glTF document.
struct GltfDocument {
  /// The nodes, meshes, accessors, bufferViews and the requested scene, if there is one, as its
  /// only scene; other members are empty. Erased are images, textures, materials, animations,
  /// cameras, extras, bounds of accessors, and attributes that do not move positions. The members
  /// below hold what is still needed of the erased parts.
  tinygltf::Model model;
  std::vector<BufferEntry> buffers;
  std::vector<StatedBounds> stated_bounds;                          ///< by accessor
  std::map<std::size_t, MeshoptView> meshopt;                       ///< by bufferView
  std::map<std::pair<std::size_t, std::size_t>, DracoEntry> draco;  ///< by mesh and primitive
  /// by mesh and primitive; ascending by attribute
  std::map<std::pair<std::size_t, std::size_t>, std::vector<AttributeEntry>> attributes;
  NamedEntries named;
  std::vector<Material> materials;                    ///< in the order of the file
  std::map<std::size_t, AlphaEntry> alpha;            ///< by material, of those that are masked
  std::vector<SkinEntry> skins;                       ///< in the order of the file
  std::vector<AnimationEntry> animations;             ///< in the order of the file
  std::vector<std::optional<Camera>> cameras;         ///< empty: invalid, there is a warning
  std::map<std::size_t, std::size_t> camera_of_node;  ///< node to camera, both in range
  std::map<std::size_t, std::uint32_t> masks;         ///< by node: its extras.sightline.mask
  std::map<std::size_t, std::string> extras;          ///< by node: JSON text of its extras
  bool has_scene = false;  ///< false: the file names no scene, every root node is loaded
  /// the file requires KHR_draco_mesh_compression: accessors have no uncompressed bytes
  bool draco_required = false;
  bool quantization = false;  ///< KHR_mesh_quantization is used or required

  /// The name of an attribute in the file.
  std::string_view name_of(VertexAttribute attribute) const {
    if (attribute >= VertexAttribute::kNamed) return named.list[named_index(attribute)].name;
    return kVertexAttributeNames[static_cast<std::size_t>(attribute)];
  }
  /// True if the accessor has a bufferView.
  static bool has_view(const tinygltf::Accessor& accessor) { return accessor.bufferView >= 0; }

  /// Counts of scenes, images, animations and attributes that were erased. Nodes and meshes are
  /// counted when they are traversed.
  ImportSkips skipped;
  std::vector<std::string> image_uris;  ///< set only if ImportOptions::skip is false

  std::vector<std::string> warnings;  ///< one sentence each
};

/// Checks the JSON text of a glTF file, erases what rays do not need, and fills a document from the
/// rest. Errors: GLTF_JSON_*, GLTF_LIMIT_*, GLTF_VALUE_INVALID, GLTF_REFERENCE_INVALID,
/// GLTF_VERSION_UNSUPPORTED, GLTF_EXTENSION_UNSUPPORTED, GLTF_SCENE_UNKNOWN. Throws the exceptions
/// of nlohmann and the allocator.
Result<GltfDocument> read_document(std::string_view json, const ImportOptions& options);

/// Names of extensions.
inline constexpr const char* kQuantization = "KHR_mesh_quantization";
inline constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

}  // namespace sightline::gltf
