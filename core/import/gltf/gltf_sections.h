#pragma once
/// Functions that check one section of a glTF file's JSON each, and erase from it what rays do not
/// need. Included by gltf_thinning.cpp and gltf_attributes.cpp only.

#include <nlohmann/json.hpp>

#include "core/import/gltf/gltf_document.h"
#include "core/import/input/json_checker.h"

namespace sightline::gltf {

/// Numbers of elements of the sections; references are checked against them.
struct Counts {
  std::size_t nodes = 0, meshes = 0, accessors = 0, views = 0, buffers = 0;
};

/// Erases every member of object.extensions except `name`. Returns that member, valid until
/// `object` changes, or null if it is absent or invalid; an invalid one is an error in `check`.
nlohmann::json* only_extension(nlohmann::json& object, const char* name, JsonChecker& check,
                               const Place& at);

// Each function checks a section (`list` is null if the file has none) and reports the first error
// to `check`. take_ functions move the section into `document`; thin_ functions leave it in the
// JSON, without what rays do not need.
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
