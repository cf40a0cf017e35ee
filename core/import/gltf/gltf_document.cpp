#include "core/import/gltf/gltf_document.h"

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_model.h"
#include "core/import/gltf/gltf_thinning.h"
#include "core/import/input/json_checker.h"
#include "core/import/input/json_guard.h"
#include "core/import/input/json_memory.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// A bound of what the model of these parts takes beside the document that it is read from.
std::uint64_t model_bytes(const nlohmann::json& root, const JsonSize& size) {
  const auto count = [&](const char* key) -> std::uint64_t {
    const auto found = root.find(key);
    return found == root.end() ? 0 : found->size();
  };
  std::uint64_t bytes = count("nodes") * sizeof(tinygltf::Node) +
                        count("accessors") * sizeof(tinygltf::Accessor) +
                        count("bufferViews") * sizeof(tinygltf::BufferView) +
                        count("meshes") * sizeof(tinygltf::Mesh);
  if (const auto meshes = root.find("meshes"); meshes != root.end()) {
    for (const auto& mesh : *meshes) {
      bytes += mesh["primitives"].size() * sizeof(tinygltf::Primitive);
    }
  }
  // The text of names and the numbers in lists are no larger than in the document.
  return 3 * bytes + document_bytes(size);
}

}  // namespace

Result<GltfDocument> read_document(std::string_view text, const ImportOptions& options) {
  auto size = guard_json(text, options.limits);
  if (!size) return std::move(size).error();
  if (Status status = try_memory(document_bytes(*size)); !status) return std::move(status).error();
  nlohmann::json root = nlohmann::json::parse(text.begin(), text.end());
  GltfDocument document;
  JsonChecker check;
  thin_gltf(root, options, document, check);
  if (!check.good()) return check.take();

  // What was erased is not read, so the size of the whole text is a bound.
  if (Status status = try_memory(model_bytes(root, *size)); !status) {
    return std::move(status).error();
  }
  document.model = read_model(root);
  return document;
}

}  // namespace sightline::gltf
