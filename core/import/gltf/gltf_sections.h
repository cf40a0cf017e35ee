#pragma once
/// The sections of a glTF file's JSON that hold geometry, checked and thinned one by one. A part of
/// gltf_thinning.cpp and gltf_attributes.cpp; nothing else includes it.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"
#include "core/import/input/json_checker.h"

namespace sightline::gltf {

/// Sizes of the sections, which references are held against.
struct Counts {
  std::size_t nodes = 0, meshes = 0, accessors = 0, views = 0, buffers = 0;
};

/// Erases everything of "extensions" but `name`, and returns that member if it is present.
nlohmann::json* only_extension(nlohmann::json& object, const char* name, JsonChecker& check,
                               const Place& at);

// Each takes a section (nullptr: the file has none), and leaves what is wrong in `check`.
void take_buffers(nlohmann::json* list, GltfDocument& document, JsonChecker& check,
                  const Place& at);
void take_skins(nlohmann::json* list, const Counts& counts, GltfDocument& document,
                JsonChecker& check, const Place& at);
void thin_views(nlohmann::json* list, const Counts& counts, GltfDocument& document,
                JsonChecker& check, const Place& at);
void thin_accessors(nlohmann::json* list, const Counts& counts, GltfDocument& document,
                    JsonChecker& check, const Place& at);
void thin_meshes(nlohmann::json* list, const Counts& counts, GltfDocument& document,
                 JsonChecker& check, const Place& at);

}  // namespace sightline::gltf

// Tests: tests/unit/import/gltf_document_test.cpp
