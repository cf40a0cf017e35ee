#pragma once
/// Fills tinygltf's structures from JSON that is already parsed and checked. tinygltf's own reader
/// would need the text, and parse it again.

#include <tiny_gltf.h>

#include <nlohmann/json.hpp>

namespace sightline::gltf {

/// Returns a model with the scenes, nodes, meshes, accessors and bufferViews of `root`; moves the
/// strings out of `root`. An accessor without a bufferView gets -1. Precondition: thin_gltf found
/// no error in `root`.
tinygltf::Model read_model(nlohmann::json& root);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
