#pragma once
/// The view of a camera as a convex region: planes of float64 numbers by the formulas of
/// docs/reference/generators.md. The planes define the region; every decision about them is exact.

#include <array>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_convex.h"
#include "core/query/ray_generators.h"

namespace sightline {

/// Returns the planes of a pinhole or orthographic camera, with its range as near and far: left,
/// right, upper, lower and near plane, and the far plane unless the range is infinite. Errors:
/// GENERATOR_POSE, VIEW_KIND (another generator), VIEW_RANGE (a number overflows).
Result<std::vector<HalfSpace>> view_frustum(const RayGenerator& camera);

/// Returns six planes, one for each face of a solid with eight corners. Corners 0 to 3 go around
/// one face, corners 4 to 7 around the opposite face; corner i + 4 is opposite corner i. Each plane
/// passes through the first three corners of its face. Errors: BOX_CORNERS (the corners of a face
/// are not all on one side of the plane of the opposite face, or coordinates overflow).
Result<std::vector<HalfSpace>> frustum_of(const std::array<Vec3d, 8>& corners);

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
