#pragma once
/// Reads which vertex attributes a document has. An invalid attribute does not make a file invalid:
/// it is left out with a warning.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/gltf_sections.h"
#include "core/import/input/json_checker.h"

namespace sightline::gltf {

/// Moves the vertex attributes that hits may need from the JSON of a primitive into
/// document.attributes. Must be called before other members of the primitive are erased.
/// draco         the primitive's KHR_draco_mesh_compression, or null
/// counts        references are checked against them
/// mesh, number  indices of the mesh, and of the primitive in the mesh
/// at            place of the primitive, for warnings
void take_attributes(nlohmann::json& primitive, nlohmann::json* draco, const Counts& counts,
                     std::size_t mesh, std::size_t number, GltfDocument& document, const Place& at);

/// Adds a warning if attributes were left out because of their names. Called once, after the last
/// primitive.
void warn_of_names(GltfDocument& document);

/// Sets scene.named_attributes from the document and the meshes of the scene.
void list_named_attributes(const GltfDocument& document, SceneDescription& scene);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
