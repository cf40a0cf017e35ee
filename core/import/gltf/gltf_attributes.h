#pragma once
/// Vertex attributes of a document, which hits may need. An invalid attribute never makes a file
/// invalid: it is left out with a warning.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/gltf_sections.h"
#include "core/import/input/json_checker.h"

namespace sightline::gltf {

/// Moves them into document.attributes. `draco` is the primitive's extension, or null.
/// Precondition: nothing of the primitive was erased before.
void take_attributes(nlohmann::json& primitive, nlohmann::json* draco, const Counts& counts,
                     std::size_t mesh, std::size_t number, GltfDocument& document, const Place& at);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
