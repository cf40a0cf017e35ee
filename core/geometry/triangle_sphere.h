#pragma once
/// Closed triangle against closed ball, exactly: touching counts.
///
/// Method   the exact distance of the center (point_triangle.h) is compared with the radius.
/// Filter   float64 for what is far away and for corners well inside.

#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The points p with |p - center| <= radius, in real arithmetic. The center is finite, the radius
/// finite and not negative.
struct Sphere {
  Vec3d center;
  double radius = 0;
};

/// Whether they have a point in common. False for a triangle that has exactly no area or a corner
/// that is not finite, as of boxes (triangle_box.h).
bool triangle_meets_box(const Triangle& triangle, const Sphere& sphere);

/// Contains the sphere.
Box3d outer_bounds(const Sphere& sphere);

}  // namespace sightline
