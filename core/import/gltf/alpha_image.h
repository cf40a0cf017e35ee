#pragma once
/// The alpha of base colour textures: finds the image of each masked material without reading it.

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/shared_column.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/view_store.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// Reads alphaCutoff and the base colour texture of each masked material. What is wrong there is no
/// error of the file: it is retained as the reason why the texture cannot be used. Precondition:
/// textures, images and samplers have not been erased.
void take_alpha(const nlohmann::json& root, GltfDocument& document);

/// Gives the masked materials of the scene their cutoff and texture. The images are referred to in
/// the bytes of `shared`, or copied if it has no owner and `copies` is true. Those of other files
/// cannot be used. Errors: those of the budget.
Status attach_alpha(const GltfDocument& document, ViewStore& views, const SharedBytes& shared,
                    bool copies, Budget& budget, SceneDescription& scene);

}  // namespace sightline::gltf

// Tests: tests/integration/alpha_cutoff_test.py
