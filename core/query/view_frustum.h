#pragma once
/// The view of a camera as planes: float64 numbers by the formulas of docs/reference/generators.md.
/// The planes define the shape; every decision about them is exact.

#include <array>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_convex.h"
#include "core/query/ray_generators.h"

namespace sightline {

/// The planes of a pinhole or an orthographic camera, with the range as near and far: left, right,
/// upper, lower and near plane, then the far one unless the range has no end. Errors:
/// GENERATOR_POSE, VIEW_KIND (another generator), VIEW_RANGE (numbers that overflow).
Result<std::vector<HalfSpace>> view_frustum(const RayGenerator& camera);

/// Six planes, one for each face of a box-like solid: corners 0 to 3 go around one face, 4 to 7
/// around the other, each behind its like. A plane goes through the first three corners of its
/// face. Errors: BOX_CORNERS (a face whose corners do not lie on one side of the plane of the
/// opposite one; coordinates that overflow).
Result<std::vector<HalfSpace>> frustum_of(const std::array<Vec3d, 8>& corners);

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
