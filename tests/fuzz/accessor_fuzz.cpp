// Accessors, views and sparse parts of any numbers over a few bytes, in a file that is otherwise
// right: positions, indices, joints, weights, bind matrices and instances all go through them.
// Input: 24 bytes for each of the accessors until half of the input is used; the rest is the BIN
// chunk.
// Run:  scripts/stress.sh fuzz --target accessor_fuzz

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "tests/fuzz/scene_check.h"

using namespace sightline;

namespace {

using nlohmann::json;
constexpr std::size_t kBytesPerAccessor = 24;

/// Small most of the time, so that many of them fit; the largest stands for every too large one.
std::uint64_t number(std::uint8_t byte) { return byte == 255 ? 1ull << 53 : byte; }

json view(std::span<const std::uint8_t> in) {
  json out = {{"buffer", 0}, {"byteOffset", number(in[0])}, {"byteLength", number(in[1])}};
  if (in[2] != 0) out["byteStride"] = number(in[2]);
  return out;
}

json accessor(std::span<const std::uint8_t> in, std::size_t views) {
  static constexpr std::array<int, 6> kComponents = {5126, 5121, 5123, 5125, 5120, 5122};
  static constexpr std::array<const char*, 5> kTypes = {"VEC3", "SCALAR", "VEC4", "MAT4", "VEC2"};
  json out = {{"componentType", kComponents[in[0] % 6]},
              {"type", kTypes[in[1] % 5]},
              {"count", number(in[2])},
              {"byteOffset", number(in[3])}};
  if (in[4] % 8 != 7) out["bufferView"] = views;
  if (in[5] % 2 == 1) out["normalized"] = true;
  if (in[6] % 4 == 3) {
    out["sparse"] = {{"count", number(in[7])},
                     {"indices",
                      {{"bufferView", views + 1},
                       {"byteOffset", number(in[8])},
                       {"componentType", kComponents[in[9] % 6]}}},
                     {"values", {{"bufferView", views + 2}, {"byteOffset", number(in[10])}}}};
  }
  return out;
}

void append_word(std::string& to, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  char bytes[4];
  std::memcpy(bytes, &word, 4);
  to.append(bytes, 4);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  json root = {{"asset", {{"version", "2.0"}}},
               {"extensionsUsed", {"KHR_mesh_quantization", "EXT_mesh_gpu_instancing"}}};
  const std::span<const std::uint8_t> input(data, size);
  const std::size_t count = std::min<std::size_t>(size / 2 / kBytesPerAccessor, 12);
  if (count == 0) return 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto in = input.subspan(i * kBytesPerAccessor, kBytesPerAccessor);
    root["accessors"].push_back(accessor(in, 3 * i));
    for (std::size_t k = 0; k < 3; ++k) root["bufferViews"].push_back(view(in.subspan(12 + 4 * k)));
  }
  // The first accessors in turn: positions, indices, a morph target, joints, weights, bind
  // matrices, instances, normals, coordinates, colours; each part of the file is there when its
  // accessor is.
  json primitive = {{"attributes", {{"POSITION", 0}}}, {"mode", 4 + data[11] % 3}};
  json skinned = {{"mesh", 0}};
  if (count > 1) primitive["indices"] = 1;
  if (count > 2) primitive["targets"] = {{{"POSITION", 2}}};
  if (count > 4) {
    primitive["attributes"]["JOINTS_0"] = 3;
    primitive["attributes"]["WEIGHTS_0"] = 4;
    skinned["skin"] = 0;
    root["skins"] = {{{"joints", {0, 1, 0}}}};
  }
  if (count > 5) root["skins"][0]["inverseBindMatrices"] = 5;
  root["nodes"] = {{{"mesh", 0}, {"translation", {1, 2, 3}}}, skinned};
  if (count > 6) {
    static constexpr std::array<const char*, 3> kNames = {"TRANSLATION", "ROTATION", "SCALE"};
    json& extension = root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"];
    for (std::size_t i = 6; i < count && i < 9; ++i) extension["attributes"][kNames[i - 6]] = i;
  }
  static constexpr std::array<const char*, 3> kAttributes = {"NORMAL", "TEXCOORD_0", "COLOR_0"};
  for (std::size_t i = 9; i < count; ++i) primitive["attributes"][kAttributes[i - 9]] = i;
  root["meshes"] = {{{"primitives", {primitive}}, {"weights", {0.5}}}};

  const auto binary = input.subspan(count * kBytesPerAccessor);
  const std::size_t padded = (binary.size() + 3) / 4 * 4;
  root["buffers"] = {{{"byteLength", binary.size()}}};
  std::string text = root.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string glb = "glTF";
  append_word(glb, 2);
  append_word(glb, 28 + text.size() + padded);
  append_word(glb, text.size());
  glb += "JSON" + text;
  append_word(glb, padded);
  glb += std::string("BIN\0", 4);
  glb.append(reinterpret_cast<const char*>(binary.data()), binary.size());
  glb.resize(glb.size() + padded - binary.size());
  fuzz::check(import_bytes(std::as_bytes(std::span(glb)), fuzz::small_limits()));
  return 0;
}
