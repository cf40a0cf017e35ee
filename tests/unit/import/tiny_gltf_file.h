#pragma once
/// Small glTF files for tests, made from JSON and numbers.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/import/import.h"

namespace sightline::test {

using nlohmann::json;

/// Appends numbers of one type, little-endian, and pads to 4 bytes; returns the byte where they
/// begin.
template <class T>
std::size_t append_numbers(std::vector<std::byte>& bytes, const std::vector<T>& numbers) {
  const std::size_t begin = bytes.size();
  bytes.resize(begin + numbers.size() * sizeof(T));
  if (!numbers.empty()) {
    std::memcpy(bytes.data() + begin, numbers.data(), numbers.size() * sizeof(T));
  }
  while (bytes.size() % 4 != 0) bytes.push_back(std::byte{0});
  return begin;
}

inline void append_word(std::vector<std::byte>& bytes, std::uint64_t value) {
  append_numbers<std::uint32_t>(bytes, {static_cast<std::uint32_t>(value)});
}

/// A GLB around the text and the bytes; no BIN chunk when there are none.
inline std::vector<std::byte> glb_of(std::string text, const std::vector<std::byte>& binary) {
  while (text.size() % 4 != 0) text += ' ';
  std::vector<std::byte> glb;
  append_word(glb, 0x46546c67);
  append_word(glb, 2);
  append_word(glb, 20 + text.size() + (binary.empty() ? 0 : 8 + binary.size()));
  append_word(glb, text.size());
  append_word(glb, 0x4e4f534a);
  for (char c : text) glb.push_back(static_cast<std::byte>(c));
  if (!binary.empty()) {
    append_word(glb, binary.size());
    append_word(glb, 0x004e4942);
    glb.insert(glb.end(), binary.begin(), binary.end());
  }
  return glb;
}

/// A file under construction: one scene, and whatever a test adds or spoils.
struct TinyFile {
  json root = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};
  std::vector<std::byte> binary;

  /// Adds numbers as a bufferView and an accessor of their own; returns the accessor.
  template <class T>
  int add(const std::vector<T>& numbers, int component, const std::string& type, std::size_t count,
          const json& more = json::object()) {
    json accessor = {{"bufferView", add_view(numbers)},
                     {"componentType", component},
                     {"count", count},
                     {"type", type}};
    accessor.update(more);
    root["accessors"].push_back(accessor);
    return static_cast<int>(root["accessors"].size()) - 1;
  }
  template <class T>
  int add_view(const std::vector<T>& numbers) {
    const std::size_t begin = append_numbers(binary, numbers);
    root["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", numbers.size() * sizeof(T)}});
    return static_cast<int>(root["bufferViews"].size()) - 1;
  }
  int add_positions(const std::vector<float>& xyz) {
    return add(xyz, 5126, "VEC3", xyz.size() / 3, {{"min", {-1, -1, -1}}, {"max", {1, 1, 1}}});
  }

  std::vector<std::byte> bytes() const {
    json whole = root;
    if (!binary.empty() && !whole.contains("buffers")) {
      whole["buffers"] = {{{"byteLength", binary.size()}}};
    }
    return glb_of(whole.dump(), binary);
  }
  Result<SceneDescription> import(const ImportOptions& options = {}) const {
    return import_bytes(bytes(), options);
  }
  /// The code of the error, or "" when it loads.
  std::string code(const ImportOptions& options = {}) const {
    const auto scene = import(options);
    return scene ? "" : scene.error().code;
  }
};

/// One node, one mesh, one triangle (0,0,0) (1,0,0) (0,1,0) with u16 indices.
inline TinyFile one_triangle() {
  TinyFile file;
  const int positions = file.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int indices = file.add<std::uint16_t>({0, 1, 2}, 5123, "SCALAR", 3);
  file.root["nodes"] = {{{"name", "only"}, {"mesh", 0}}};
  file.root["meshes"] = {
      {{"name", "triangle"},
       {"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}}};
  return file;
}

}  // namespace sightline::test
