#pragma once
/// Closed triangle against closed capsule, exactly: touching counts.
///
/// Method   compares the exact distance between the capsule's axis and the triangle
///          (triangle_distance.h) with the radius.
/// Filter   the float64 interval of that distance.

#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The points within `radius` of the segment from `from` to `to`, in real arithmetic. All numbers
/// are finite, and the radius is not negative; the two ends may be equal. check_boxes
/// (core/query/box_batch.h) tests that.
struct Capsule {
  Vec3d from, to;
  double radius = 0;
};

/// True if triangle and capsule have at least one point in common. False for a triangle that has
/// exactly no area or a corner that is not finite.
bool triangle_meets_box(const Triangle& triangle, const Capsule& capsule);

/// An axis-aligned box that contains the capsule, rounded outwards; a bound is infinite if it
/// overflows.
Box3d outer_bounds(const Capsule& capsule);

}  // namespace sightline

// Tests: tests/unit/query/box_batch_test.cpp
