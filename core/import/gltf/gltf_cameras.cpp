#include "core/import/gltf/gltf_cameras.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/import/input/json_checker.h"

namespace sightline::gltf {

using nlohmann::json;

namespace {

/// A finite number of at least 0, else nothing.
std::optional<double> size_of(const json& object, const char* key) {
  const json* const value = member_of(object, key);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  const auto number = value->get<double>();
  return std::isfinite(number) && number >= 0 ? std::optional(number) : std::nullopt;
}

std::optional<Camera> read_camera(const json& object) {
  Camera camera;
  if (const json* name = member_of(object, "name"); name != nullptr && name->is_string()) {
    camera.name = name->get<std::string>();
  }
  const json* const orthographic = member_of(object, "orthographic");
  const json* const lens =
      orthographic != nullptr ? orthographic : member_of(object, "perspective");
  if (lens == nullptr) return std::nullopt;
  camera.orthographic = orthographic != nullptr;
  const auto size = size_of(*lens, camera.orthographic ? "ymag" : "yfov");
  const auto near = size_of(*lens, "znear");
  const bool is_endless = !camera.orthographic && member_of(*lens, "zfar") == nullptr;
  const auto far =
      is_endless ? std::optional(std::numeric_limits<double>::infinity()) : size_of(*lens, "zfar");
  if (!size || !near || !far || *size == 0 || !(*near < *far)) return std::nullopt;
  if (!camera.orthographic && *size >= std::numbers::pi) return std::nullopt;
  camera.size_y = *size;
  camera.near = *near;
  camera.far = *far;
  return camera;
}

}  // namespace

void take_cameras(const json& root, GltfDocument& document) {
  const json* const list = member_of(root, "cameras");
  if (list == nullptr || !list->is_array()) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    auto camera = read_camera((*list)[i]);
    if (camera) camera->file_camera = static_cast<std::uint32_t>(i);
    if (!camera) {
      document.warnings.push_back("camera " + std::to_string(i) +
                                  ": is not one of glTF and cannot be asked for");
    }
    document.cameras.push_back(std::move(camera));
  }
  const json* const nodes = member_of(root, "nodes");
  if (nodes == nullptr || !nodes->is_array()) return;
  for (std::size_t i = 0; i < nodes->size(); ++i) {
    const json* const shown = member_of((*nodes)[i], "camera");
    if (shown == nullptr || !shown->is_number_unsigned()) continue;
    const auto number = shown->get<std::uint64_t>();
    if (number < document.cameras.size() && document.cameras[number])
      document.camera_of_node[i] = number;
  }
}

}  // namespace sightline::gltf
