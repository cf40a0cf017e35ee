#include "core/import/gltf/gltf_document.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_thinning.h"
#include "core/import/input/json_checker.h"
#include "core/import/input/json_guard.h"
#include "core/import/input/json_memory.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// tinygltf opens nothing: buffers and images were taken out, and if it tried, these say no.
tinygltf::FsCallbacks no_files() {
  tinygltf::FsCallbacks callbacks = {};
  callbacks.FileExists = [](const std::string&, void*) { return false; };
  callbacks.ExpandFilePath = [](const std::string&, void*) { return std::string(); };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>*, std::string*, const std::string&,
                               void*) { return false; };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&,
                                void*) { return false; };
  return callbacks;
}

bool no_image(tinygltf::Image*, const int, std::string*, std::string*, int, int,
              const unsigned char*, int, void*) {
  return true;
}

/// How many parts tinygltf must find. It drops one that it cannot read without saying so; after the
/// checks there is none.
struct Parts {
  std::size_t nodes = 0, accessors = 0, views = 0;
  std::vector<std::size_t> primitives;  ///< per mesh

  bool operator==(const Parts&) const = default;
};

Parts parts_of(const nlohmann::json& root) {
  const auto size = [&](const char* key) {
    const auto found = root.find(key);
    return found == root.end() ? 0 : found->size();
  };
  Parts parts = {size("nodes"), size("accessors"), size("bufferViews"), {}};
  if (const auto meshes = root.find("meshes"); meshes != root.end()) {
    for (const auto& mesh : *meshes) parts.primitives.push_back(mesh["primitives"].size());
  }
  return parts;
}

Parts parts_of(const tinygltf::Model& model) {
  Parts parts = {model.nodes.size(), model.accessors.size(), model.bufferViews.size(), {}};
  for (const auto& mesh : model.meshes) parts.primitives.push_back(mesh.primitives.size());
  return parts;
}

/// A bound of what tinygltf's model of these parts takes beside the document that it is read from.
std::uint64_t model_bytes(const Parts& parts, const JsonSize& size) {
  std::uint64_t bytes =
      parts.nodes * sizeof(tinygltf::Node) + parts.accessors * sizeof(tinygltf::Accessor) +
      parts.views * sizeof(tinygltf::BufferView) + parts.primitives.size() * sizeof(tinygltf::Mesh);
  for (const std::size_t count : parts.primitives) bytes += count * sizeof(tinygltf::Primitive);
  // Its vectors grow by doubling; the text of names and the numbers in lists are no larger than in
  // the document.
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

  // The stand-in for absent views is one more view, which nothing ever reads.
  root["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 1}});
  const Parts expected = parts_of(root);
  const std::string thin = root.dump();
  root = nullptr;  // from here on the small text is enough
  if (thin.size() > std::numeric_limits<unsigned>::max()) {
    return beyond_limit("JSON_BYTES", "bytes of JSON", thin.size(),
                        std::numeric_limits<unsigned>::max());
  }
  // What was erased is not there to be read again, so the size of the whole text is a bound.
  if (Status status = try_memory(document_bytes(*size) + model_bytes(expected, *size)); !status) {
    return std::move(status).error();
  }
  tinygltf::TinyGLTF reader;
  reader.SetFsCallbacks(no_files());
  reader.SetImageLoader(no_image, nullptr);
  std::string refusal, remarks;
  if (!reader.LoadASCIIFromString(&document.model, &refusal, &remarks, thin.data(),
                                  static_cast<unsigned>(thin.size()), "",
                                  tinygltf::REQUIRE_VERSION)) {
    return invalid("GLTF_STRUCTURE_INVALID", "tinygltf: " + shortened(refusal, 200));
  }
  if (parts_of(document.model) != expected) {
    return invalid("GLTF_STRUCTURE_INVALID", "tinygltf did not read every part of the file");
  }
  return document;
}

}  // namespace sightline::gltf
