#pragma once
/// Imports files of the ray tracer POV-Ray that consist of boxes: box { <a>, <b> pigment {..} .. }.
/// Source: the reference of POV-Ray 3.7, 2.4.1, 3.4.1 and 3.4.5.

#include <span>
#include <string_view>

#include "core/base/result.h"
#include "core/import/input/limits.h"
#include "core/scene/scene_description.h"

namespace sightline::pov {

/// True if the text begins with a comment, "#version", or a word that POV-Ray allows at the top
/// level of a file.
bool looks_like_pov(std::string_view text);

/// Returns a scene in which every box is an instance of a cube from 0 to 1, of a node that is named
/// by the box's line ("box, line 5"). The instance's matrix is x * (max - min) + min per axis
/// in float64. So corners equal those of the file to the last bit wherever max - min is exact in
/// float64. Corners may be in either order. The text of a box's pigment, in a
/// texture or not, is the name of its material; boxes with equal pigments share a mesh. A pigment
/// of one plain colour (rgb, rgbf, rgbt, rgbft) is the vertex colour of its box.
///
/// Ignored: camera, light_source, global_settings, background, #version, and the finish of a box.
///
/// Errors: POV_SYNTAX_INVALID and POV_FEATURE_UNSUPPORTED (other objects, transforms, directives,
/// expressions), naming the line; GLTF_LIMIT_JSON_BYTES, _JSON_DEPTH (of braces), _INSTANCES,
/// _GEOMETRY_BYTES. Throws std::bad_alloc.
Result<SceneDescription> import_boxes(std::string_view text, const ImportLimits& limits);

}  // namespace sightline::pov
