#pragma once
/// Reads which animations a document has. A scene loads without them, so an invalid one does not
/// make a file invalid: it cannot be sampled.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"

namespace sightline::gltf {

/// Sets document.animations from the file's JSON, whose members need not have been checked. What is
/// wrong with one becomes its `problem`.
void take_animations(const nlohmann::json& root, GltfDocument& document);

}  // namespace sightline::gltf

// Tests: tests/integration/poses_test.py
