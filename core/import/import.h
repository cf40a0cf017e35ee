#pragma once
/// Imports glTF 2.0 (.glb and .gltf) into a scene description, reading only what rays need. No byte
/// of the input is trusted. The result is a description whose every index is in range, or an Error
/// that names the place ("accessor 7: needs 1200 bytes, view has 900"). ImportLimits bounds time
/// and memory. No file outside of the scene's folder is opened.
///
/// What is applied:
/// - node matrices and TRS (transform.h has the formula), EXT_mesh_gpu_instancing
/// - KHR_mesh_quantization, EXT_meshopt_compression, KHR_draco_mesh_compression, sparse accessors
/// - morph targets with their default weights (positions.h has the formula)
/// - skins as posed by the file's own nodes (skinning.h has the formula)
/// SceneDescription::poser applies other weights, transforms and times of animations later.
///
/// What is left out:
/// - points, lines and primitives without POSITION, which are counted
/// - images, materials except names, doubleSided and colours, keys of animations, lights, extras except
///   masks
///
/// A file that requires an unknown extension is refused; the error names the extension.

#include <cstddef>
#include <filesystem>
#include <span>

#include "core/base/result.h"
#include "core/import/input/options.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// Imports a .glb, a .gltf with the files beside it, or a .pov made of boxes. The format is
/// recognised by the first bytes, not by the name. Files that a .gltf refers to must be in its own
/// folder (after resolving symbolic links).
///
/// Errors, by kind:
///   kNotFound     GLTF_FILE_UNREADABLE
///   kMalformed    GLTF_CONTAINER_INVALID, GLTF_JSON_INVALID, GLTF_JSON_DUPLICATE_KEY
///   kUnsupported  GLTF_VERSION_UNSUPPORTED, GLTF_EXTENSION_UNSUPPORTED
///   kTooLarge     GLTF_LIMIT_FILE_BYTES, _JSON_BYTES, _JSON_DEPTH, _JSON_VALUES, _TRIANGLES,
///                 _NODES, _NODE_DEPTH, _INSTANCES, _GEOMETRY_BYTES, _ZERO_FILLED
///   kOutOfSpace   GLTF_OUT_OF_MEMORY
///   kInvalid      GLTF_VALUE_INVALID (wrong type or value),
///                 GLTF_REFERENCE_INVALID (no such index), GLTF_SCENE_UNKNOWN,
///                 GLTF_HIERARCHY_INVALID, GLTF_TRANSFORM_INVALID, GLTF_URI_REFUSED,
///                 GLTF_BUFFER_INVALID, GLTF_ACCESSOR_INVALID,
///                 GLTF_ACCESSOR_OUT_OF_BOUNDS, GLTF_INDEX_OUT_OF_RANGE, GLTF_INSTANCING_INVALID,
///                 GLTF_SKIN_INVALID, GLTF_COMPRESSION_INVALID
///   kMalformed, kUnsupported  POV_SYNTAX_INVALID, POV_FEATURE_UNSUPPORTED (pov_scene.h)
///   kCancelled    CANCELLED (ImportOptions::progress)
///   kInternal     GLTF_INTERNAL
/// Error::pointer points into the file's own JSON. No exception leaves. After an error nothing of
/// the scene remains.
Result<SceneDescription> import_file(const std::filesystem::path& file,
                                     const ImportOptions& options);

/// Imports a file from memory: a .glb, a .gltf whose buffers are data URIs, or a .pov. Other
/// buffers are found by ImportOptions::neighbour; without it they are the error GLTF_URI_REFUSED.
/// `bytes` must be valid during the call, and later if the options have an `owner`. Errors: those
/// of import_file and of ImportOptions::neighbour.
Result<SceneDescription> import_bytes(std::span<const std::byte> bytes,
                                      const ImportOptions& options);

}  // namespace sightline
