#pragma once
/// glTF 2.0 (.glb and .gltf) to a scene description, reading only what a ray needs. Every byte of
/// the input is hostile. The result is a description whose every index is in range, or an Error
/// that names the place ("accessor 7: needs 1200 bytes, view has 900"). Time and memory are bounded
/// by ImportLimits. Never opens a file outside the scene's own folder.
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
#include <filesystem>
#include <span>

#include "core/base/result.h"
#include "core/import/input/options.h"
#include "core/scene/scene_description.h"

namespace sightline {

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
///                 GLTF_SKIN_INVALID, GLTF_COMPRESSION_INVALID
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
