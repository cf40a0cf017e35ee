#pragma once
/// Reads the cameras of a document. No answer about triangles needs a camera, so an invalid one
/// does not prevent loading.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"

namespace sightline::gltf {

/// Sets document.cameras and document.camera_of_node from the file's JSON, whose members need not
/// have been checked. Adds a warning for each invalid camera.
void take_cameras(const nlohmann::json& root, GltfDocument& document);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
