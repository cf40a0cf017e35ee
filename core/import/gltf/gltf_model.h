#pragma once
/// Fills the structures of tinygltf from JSON that is parsed and checked already. Its own reader
/// would need the text again.

#include <tiny_gltf.h>

#include <nlohmann/json.hpp>

namespace sightline::gltf {

/// Takes the scenes, nodes, meshes, accessors and bufferViews of `root`, whose strings are moved.
/// The bufferView of an accessor that names none is -1. Precondition: thin_gltf found nothing wrong.
tinygltf::Model read_model(nlohmann::json& root);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
