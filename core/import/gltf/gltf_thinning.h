#pragma once
/// Makes the JSON of a glTF file small and certain before a model is made of it.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"
#include "core/import/input/json_checker.h"

namespace sightline::gltf {

/// Checks asset.version and extensionsRequired, moves buffers, materials and the choice of scene
/// into `document`, checks every member of the sections that stay, and erases all others. What is
/// wrong is left in `check`.
void thin_gltf(nlohmann::json& root, const ImportOptions& options, GltfDocument& document,
               JsonChecker& check);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
