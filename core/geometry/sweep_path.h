#pragma once
/// SweepPath: the line segment along which a swept shape moves.

#include "core/geometry/vec3.h"

namespace sightline {

/// The shape's centre moves over origin + t * direction for tmin <= t <= tmax; the shape does not
/// turn. origin is in scene units, t in units of |direction|. Preconditions, which check_rays
/// (core/query/ray_batch.h) tests: origin and direction are finite, direction is not zero, the
/// limits are not NaN, and tmin <= tmax.
struct SweepPath {
  Vec3d origin, direction;
  double tmin = 0, tmax = 0;
};

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
