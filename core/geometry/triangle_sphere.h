#pragma once
/// Closed triangle against closed ball, exactly: touching counts.
///
/// Method   They meet if and only if one of these does: a corner (|v|^2 <= r^2); an edge where the
///          center projects into it (|a x e|^2 <= r^2 |e|^2); the plane where the center projects
///          into the triangle ((n.a)^2 <= r^2 |n|^2). All of a, v are seen from the center.
/// Filter   float64 for what is far away and for corners well inside; the rest is decided in Dyadic
///          numbers, of degree six at most.

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
