#pragma once
/// Cameras of a file. No answer about its triangles needs one, so nothing that is wrong with them
/// keeps a file from loading.

#include <nlohmann/json.hpp>

#include "core/import/gltf_document.h"

namespace sightline::gltf {

/// Fills document.cameras and camera_of_node from the file's JSON, which is not checked yet.
void take_cameras(const nlohmann::json& root, GltfDocument& document);

}  // namespace sightline::gltf
