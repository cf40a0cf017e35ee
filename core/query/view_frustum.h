#pragma once
/// The view of a camera as a convex region: planes of float64 numbers by the formulas of
/// docs/reference/generators.md. The planes define the region (triangle_convex.h); every decision
/// about them is exact.

#include <array>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_convex.h"
#include "core/query/ray_generators.h"

namespace sightline {

/// Returns the planes of a pinhole or orthographic camera: left, right, upper, lower and near
/// plane, and the far plane unless range.tmax is infinite. range.tmin and tmax are the distances of
/// near and far plane along `forward`, in scene units. Errors: GENERATOR_POSE, VIEW_KIND (another
/// generator), VIEW_RANGE (a number overflows). Throws std::bad_alloc.
Result<std::vector<HalfSpace>> view_frustum(const RayGenerator& camera);

/// Returns six planes, one for each face of a solid with eight corners. Corners 0 to 3 go around
/// one face, corners 4 to 7 around the opposite face; an edge joins corner i + 4 to corner i. Each
/// plane is computed in float64 from the first three corners of its face. Errors: BOX_CORNERS (the
/// four other corners are not strictly on one side of a face's plane, three corners lie on a line,
/// or coordinates overflow). Throws std::bad_alloc.
Result<std::vector<HalfSpace>> frustum_of(const std::array<Vec3d, 8>& corners);

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
