#pragma once
/// Reads which vertex attributes a document has. An invalid attribute does not make a file invalid:
/// it is left out with a warning.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/gltf_sections.h"
#include "core/import/input/json_checker.h"

namespace sightline::gltf {

/// Moves the attributes of a primitive from its JSON into document.attributes. `draco` is the
/// primitive's KHR_draco_mesh_compression, or null. `at` is the place of the primitive, for
/// warnings. Must be called before other members of the primitive are erased.
void take_attributes(nlohmann::json& primitive, nlohmann::json* draco, const Counts& counts,
                     std::size_t mesh, std::size_t number, GltfDocument& document, const Place& at);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
