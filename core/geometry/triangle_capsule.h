#pragma once
/// Closed triangle against closed capsule, exactly: touching counts.
///
/// Method   the exact distance of the axis (triangle_distance.h) is compared with the radius.
/// Filter   the interval of that distance.

#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The points within `radius` of the segment from..to, in real arithmetic. All finite, the radius
/// not negative; the ends may coincide.
struct Capsule {
  Vec3d from, to;
  double radius = 0;
};

/// Whether they have a point in common. False for a triangle that has exactly no area or a corner
/// that is not finite, as of boxes (triangle_box.h).
bool triangle_meets_box(const Triangle& triangle, const Capsule& capsule);

/// Contains the capsule.
Box3d outer_bounds(const Capsule& capsule);

}  // namespace sightline

// Tests: tests/unit/query/box_batch_test.cpp
