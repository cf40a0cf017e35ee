#pragma once
/// glTF 2.0 (.glb and .gltf) to a scene description, reading only what a ray needs. Every byte of
/// the input is hostile. The result is a description whose every index is in range, or an Error
/// that names the place ("accessor 7: needs 1200 bytes, view has 900"). Time and memory are bounded
/// by the limits below. Never opens a file outside the scene's own folder.
///
/// Applied:
/// - node matrices and TRS (transform.h has the formula), EXT_mesh_gpu_instancing
/// - KHR_mesh_quantization, EXT_meshopt_compression, KHR_draco_mesh_compression, sparse accessors
/// - morph targets with their default weights (positions.h has the formula)
/// - skins as posed by the file's own nodes (skinning.h has the formula)
///
/// Left out:
/// - points, lines and primitives without POSITION, which are counted
/// - images, materials except names, doubleSided and colours, animations, lights, extras except
///   masks
///
/// An extension that the file requires and that is not known here is refused by name.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/scene/scene_description.h"

namespace sightline {

struct ImportLimits {
  std::uint64_t file_bytes = 1ull << 33;  ///< the scene file and each external buffer
  std::uint64_t json_bytes = 256ull << 20;
  std::uint32_t json_depth = 256;
  std::uint64_t json_values = 16u << 20;  ///< numbers, strings, arrays, ... in the JSON text
  std::uint64_t triangles = 1ull << 31;   ///< over unique meshes
  std::uint32_t nodes = 4u << 20;
  std::uint32_t node_depth = 4096;
  std::uint32_t instances = 16u << 20;
  /// Positions, indices and instances in memory. Many accessors may show the same bytes of the
  /// file, so the file's size alone does not bound it.
  std::uint64_t geometry_bytes = 1ull << 33;
  std::uint32_t zero_filled = 1u << 22;  ///< elements of an accessor that has no bytes in the file
};

/// The bytes of a file beside the scene's, by its relative path, which has passed all checks of its
/// text; they outlive the import.
using NeighbourFinder = std::function<Result<std::span<const std::byte>>(const std::string& path)>;

struct ImportOptions {
  ImportLimits limits = {};
  /// Empty: the file's default scene, else its first, else (a file without scenes) every root node.
  std::optional<std::uint32_t> scene = {};
  /// False: everything that a ray does not need is read as well, and thrown away (unskipped.h). The
  /// description is the same but for counts.touched; what is wrong in the rest is no error.
  bool skip = true;
  /// For import_bytes. Empty: there are no other files.
  NeighbourFinder neighbour = {};
  /// For import_bytes. Owns the bytes, which must not change while it lives. Meshes then refer to
  /// positions and indices in place, unless these have to be changed. Null: they are copied.
  /// (import_file copies, because anybody may write to the file.)
  std::shared_ptr<const void> keeper = {};
  /// Called with each part of those bytes that may be read after the import, from several threads.
  std::function<void(std::span<const std::byte>)> claim = {};
  /// Whether vertex attributes (normals, texture coordinates, colours) are copied, with what is
  /// compressed along with them. It matters only without a `keeper`: with one, they are never read
  /// here, and hits read them in place. Without a `keeper` and without copies no hit has
  /// attributes.
  bool copies_attributes = false;
  /// Reports the stage "importing", by nodes. The import ends early (CANCELLED) when it is
  /// cancelled. May be null.
  Progress* progress = nullptr;
};

/// Reads a mapped .glb, a .gltf with its neighbours, or a .pov made of boxes, told apart by how
/// they begin. External buffers must lie in the file's own folder (symbolic links included). The
/// name does not matter: GLB is known by its magic.
///
/// Errors, by kind:
///   kNotFound     GLTF_FILE_UNREADABLE
///   kMalformed    GLTF_CONTAINER_INVALID, GLTF_JSON_INVALID, GLTF_JSON_DUPLICATE_KEY
///   kUnsupported  GLTF_VERSION_UNSUPPORTED, GLTF_EXTENSION_UNSUPPORTED
///   kTooLarge     GLTF_LIMIT_FILE_BYTES, _JSON_BYTES, _JSON_DEPTH, _JSON_VALUES, _TRIANGLES,
///                 _NODES, _NODE_DEPTH, _INSTANCES, _GEOMETRY_BYTES, _ZERO_FILLED
///   kOutOfSpace   GLTF_OUT_OF_MEMORY
///   kInvalid      GLTF_VALUE_INVALID (wrong type or value), GLTF_REFERENCE_INVALID (no such
///   index),
///                 GLTF_SCENE_UNKNOWN, GLTF_HIERARCHY_INVALID, GLTF_TRANSFORM_INVALID,
///                 GLTF_URI_REFUSED, GLTF_BUFFER_INVALID, GLTF_ACCESSOR_INVALID,
///                 GLTF_ACCESSOR_OUT_OF_BOUNDS, GLTF_INDEX_OUT_OF_RANGE, GLTF_INSTANCING_INVALID,
///                 GLTF_SKIN_INVALID, GLTF_COMPRESSION_INVALID, GLTF_STRUCTURE_INVALID (tinygltf's
///                 own verdict)
///   kMalformed, kUnsupported  POV_SYNTAX_INVALID, POV_FEATURE_UNSUPPORTED (pov_scene.h)
///   kInternal     GLTF_INTERNAL
/// Error::pointer points into the file's own JSON.
Result<SceneDescription> import_file(const std::filesystem::path& file,
                                     const ImportOptions& options);

/// import_file from memory: a .glb, or a .gltf whose buffers are data URIs (an external one is an
/// error).
Result<SceneDescription> import_bytes(std::span<const std::byte> bytes,
                                      const ImportOptions& options);

}  // namespace sightline
