#pragma once
/// Warns of materials that are not opaque: rays hit them as if they were.

#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// Appends one warning for each kind (alphaMode MASK, alphaMode BLEND, KHR_materials_transmission)
/// that a triangle of the scene has: the number of materials, of placed triangles, and names.
void add_alpha_warnings(SceneDescription& scene);

}  // namespace sightline::gltf

// Tests: tests/integration/alpha_test.py
