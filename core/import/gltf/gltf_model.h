#pragma once
/// Makes tinygltf's structures from JSON that is already parsed and checked. tinygltf's own reader
/// needs the text, and would parse the text again.

#include <tiny_gltf.h>

#include <nlohmann/json.hpp>

namespace sightline::gltf {

/// Returns a model with the scenes, nodes, meshes, accessors and bufferViews of `root`, whose
/// strings are moved out. An accessor without a bufferView gets the bufferView -1. Precondition:
/// thin_gltf (gltf_thinning.h) has reduced `root` and found no error.
tinygltf::Model read_model(nlohmann::json& root);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
