#pragma once
/// Reduces the JSON of a glTF file to what rays need, and checks it, before a model is made of it.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"
#include "core/import/input/json_checker.h"

namespace sightline::gltf {

/// Checks asset.version and extensionsRequired; moves buffers, materials and the choice of scene
/// into `document`; checks every member of the remaining sections; erases all other sections.
/// Reports the first error to `check`; `root` and `document` are then unspecified.
void thin_gltf(nlohmann::json& root, const ImportOptions& options, GltfDocument& document,
               JsonChecker& check);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
