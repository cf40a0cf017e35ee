#pragma once
/// Files of the ray tracer POV-Ray that are made of boxes: box { <a>, <b> pigment {..} .. }.
/// Source: the reference of POV-Ray 3.7, 2.4.1 and 3.4.1.

#include <span>
#include <string_view>

#include "core/base/result.h"
#include "core/import/input/limits.h"
#include "core/scene/scene_description.h"

namespace sightline::pov {

/// Whether a text begins as such a file does: with a comment, "#version", or a word that POV-Ray
/// has at the top of a file.
bool looks_like_pov(std::string_view text);

/// Every box is an instance of a cube from 0 to 1, under a node named by its line ("box, line 5").
/// Its matrix is x * (max - min) + min per axis in float64: corners are those of the file to the
/// last bit wherever a float64 edge gives them. Corners may come in either order. A box's pigment,
/// as it is written, is the name of its material; boxes of one pigment share a mesh.
///
/// Skipped: camera, light_source, global_settings, background, #version, and the finish of a box.
///
/// Errors: POV_SYNTAX_INVALID and POV_FEATURE_UNSUPPORTED (other objects, transforms, directives,
/// expressions), naming the line; GLTF_LIMIT_JSON_BYTES, _JSON_DEPTH (of braces), _INSTANCES,
/// _GEOMETRY_BYTES.
Result<SceneDescription> import_boxes(std::string_view text, const ImportLimits& limits);

}  // namespace sightline::pov
