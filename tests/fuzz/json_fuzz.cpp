// The JSON of a glTF file: the guard lets through exactly what a parser takes, and what is made of
// it can be followed without a look at types and ranges.
// Run:  scripts/stress.sh fuzz --target json_fuzz

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/import/gltf/gltf_document.h"
#include "core/import/input/json_guard.h"
#include "tests/fuzz/scene_check.h"

using namespace sightline;

namespace {

void check_document(const gltf::GltfDocument& document) {
  const auto& model = document.model;
  const auto in = [](int index, std::size_t count) {
    return index >= 0 && static_cast<std::size_t>(index) < count;
  };
  for (const auto& node : model.nodes) {
    fuzz::require(node.mesh == -1 || in(node.mesh, model.meshes.size()), "meshes exist");
    fuzz::require(node.skin == -1 || in(node.skin, document.skins.size()), "skins exist");
    for (int child : node.children) fuzz::require(in(child, model.nodes.size()), "children exist");
  }
  for (const auto& mesh : model.meshes) {
    for (const auto& primitive : mesh.primitives) {
      fuzz::require(primitive.material == -1 || in(primitive.material, document.materials.size()),
                    "materials exist");
      fuzz::require(primitive.indices == -1 || in(primitive.indices, model.accessors.size()),
                    "indices exist");
      for (const auto& [name, accessor] : primitive.attributes) {
        fuzz::require(in(accessor, model.accessors.size()), "attributes exist");
      }
    }
  }
  for (const auto& accessor : model.accessors) {
    fuzz::require(accessor.bufferView == -1 || in(accessor.bufferView, model.bufferViews.size()),
                  "views exist");
  }
  for (const auto& view : model.bufferViews) {
    fuzz::require(in(view.buffer, std::max<std::size_t>(document.buffers.size(), 1)),
                  "buffers exist");
  }
  fuzz::require(model.images.empty() && model.textures.empty() && model.animations.empty(),
                "images and animations stay outside");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const ImportOptions options = fuzz::small_limits();
  const auto guarded = gltf::guard_json(text, options.limits);
  const bool is_json = nlohmann::json::accept(text.begin(), text.end());
  if (guarded) {
    fuzz::require(is_json, "what the guard lets through is JSON");
    fuzz::require(guarded->bytes == size && guarded->values <= options.limits.json_values,
                  "its size is told");
  } else {
    fuzz::require(guarded.error().message.size() < 1000, "messages do not echo the text");
    fuzz::require(guarded.error().code != "GLTF_JSON_INVALID" || !is_json,
                  "only what is no JSON is called so");
  }
  const auto document = gltf::read_document(text, options);
  if (document) {
    fuzz::require(guarded.ok(), "the guard is asked first");
    check_document(*document);
  } else {
    fuzz::require(!document.error().code.empty(), "errors have a code");
  }
  return 0;
}
