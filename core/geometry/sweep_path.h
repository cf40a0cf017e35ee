#pragma once
/// The way of a swept shape.

#include "core/geometry/vec3.h"

namespace sightline {

/// The shape's centre is origin + t * direction, tmin <= t <= tmax. As checked for rays: finite but
/// for the limits, the direction not zero.
struct SweepPath {
  Vec3d origin, direction;
  double tmin = 0, tmax = 0;
};

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
