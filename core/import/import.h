#pragma once
/// glTF 2.0 (.glb and .gltf) to a scene description, reading only what a ray needs.
/// Every byte of the input is hostile: the answer is a description whose every index is in range,
/// or an Error that names the place ("accessor 7: needs 1200 bytes, view has 900"). Bounded time
/// and memory: limits below. Never opens a file outside the scene's own folder.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "core/scene/scene_description.h"

namespace sightline {

struct ImportLimits {
  std::uint64_t file_bytes = 1ull << 33;
  std::uint64_t json_bytes = 256ull << 20;
  std::uint32_t json_depth = 256;
  std::uint64_t triangles = 1ull << 31;  ///< over unique meshes
  std::uint32_t nodes = 4u << 20;
  std::uint32_t node_depth = 4096;
  std::uint32_t instances = 16u << 20;
};

struct ImportOptions {
  ImportLimits limits;
  std::optional<std::uint32_t> scene;  ///< empty: the file's default scene, else its first
};

/// Reads a mapped .glb or a .gltf with its neighbours. External buffers must lie in the file's own
/// folder (symbolic links included).
Result<SceneDescription> import_file(const std::filesystem::path& file,
                                     const ImportOptions& options);

/// The same from memory: a .glb, or a .gltf whose buffers are data URIs (an external one is an
/// error).
Result<SceneDescription> import_bytes(std::span<const std::byte> bytes,
                                      const ImportOptions& options);

}  // namespace sightline
