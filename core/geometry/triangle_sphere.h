#pragma once
/// Closed triangle against closed ball, exactly: touching counts.
///
/// Method   compares the exact distance of the center from the triangle (point_triangle.h) with the
///          radius.
/// Filter   float64. It decides if the triangle is far away, or if a corner is well inside.

#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The points p with |p - center| <= radius, in real arithmetic. The center is finite; the radius
/// is finite and not negative. check_boxes (core/query/box_batch.h) tests that.
struct Sphere {
  Vec3d center;
  double radius = 0;
};

/// True if triangle and ball have at least one point in common. False for a triangle that has
/// exactly no area or a corner that is not finite.
bool triangle_meets_box(const Triangle& triangle, const Sphere& sphere);

/// An axis-aligned box that contains the sphere, rounded outwards; a bound is infinite if it
/// overflows.
Box3d outer_bounds(const Sphere& sphere);

}  // namespace sightline
