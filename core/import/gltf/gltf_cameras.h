#pragma once
/// Cameras of a file. No answer about triangles needs one, so an invalid camera never prevents
/// loading.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"

namespace sightline::gltf {

/// Fills document.cameras and camera_of_node from the file's JSON, which is not checked yet.
void take_cameras(const nlohmann::json& root, GltfDocument& document);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
