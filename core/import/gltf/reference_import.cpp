#include "core/import/gltf/reference_import.h"

#include <vector>

#include "core/import/gltf/mesh_reader.h"
#include "core/import/input/mapped_file.h"

namespace sightline::gltf {

void read_what_was_skipped(const GltfDocument& document, std::span<const std::byte> file,
                           BufferStore& buffers, AccessorReader& accessors,
                           const ImportLimits& limits, const SceneDescription& scene) {
  read_all(file);
  for (std::size_t i = 0; i < document.buffers.size(); ++i) {
    if (const auto bytes = buffers.bytes(i)) read_all(*bytes);
  }
  for (const std::string& uri : document.image_uris) {
    if (const auto bytes = buffers.neighbour(uri)) read_all(*bytes);
  }
  std::vector<bool> is_shown(document.model.meshes.size(), false);
  for (const auto& mesh : scene.meshes) is_shown[mesh->file_mesh] = true;
  for (std::size_t i = 0; i < is_shown.size(); ++i) {
    if (is_shown[i]) continue;
    // Each with memory of its own, which is free before the next one comes.
    SceneDescription spare;
    Budget budget(limits);
    Warnings warnings;
    const SharedBytes copied;
    MeshReader meshes(document, accessors, copied, false, budget, spare, warnings);
    tinygltf::Node node;
    node.mesh = static_cast<int>(i);
    static_cast<void>(meshes.mesh_of(node));
    static_cast<void>(meshes.finish());
  }
}

}  // namespace sightline::gltf
