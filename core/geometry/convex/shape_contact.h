#pragma once
/// How far a shape has to move until it is clear of a triangle, exactly.
///
/// The depth of a shape S in a triangle T is the greatest lower bound of the lengths of the
/// translations after which S has no point in T. The contact normal is the direction of a
/// translation of this length; every longer translation along it leaves no common point.
///
/// Method   of boxes and hulls the least overlap along the normals of the Minkowski difference
///          (penetration.h). Of a ball or capsule the radius less the distance of its center or
///          axis, along the line between the nearest points. If the center or axis meets T, the
///          radius and the depth of the center or axis.
/// Proofs   docs/explanation/exactness-boxes.md.

#include <optional>

#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/convex/penetration.h"
#include "core/geometry/convex/point_hull.h"
#include "core/geometry/triangle.h"
#include "core/geometry/triangle_capsule.h"
#include "core/geometry/triangle_sphere.h"

namespace sightline {

/// Depth and contact normal. Each number is the exact one rounded once. If several directions have
/// the least depth, the normal is that of the triangle on its counter-clockwise side, else its
/// reverse. Else it is chosen among the normals of the shape's faces and the cross products of an
/// edge of both: the largest x comes first, then the largest y, then the largest z.
struct ShapeContact {
  double depth = 0;  ///< +inf if no translation separates them, or beyond the largest float64
  Vec3d normal;      ///< unit; zero if no translation separates them
};

/// The contact of a shape that meets the triangle. Preconditions: triangle_meets_box is true for
/// them. Throws std::bad_alloc. Cost: 20 to 60 us; of a hull of 32 points 75 us, of 256 points 3 ms.
ShapeContact contact_of(const Box3d& box, const Triangle& triangle);
ShapeContact contact_of(const OrientedBox& box, const Triangle& triangle);
ShapeContact contact_of(const Capsule& capsule, const Triangle& triangle);
inline ShapeContact contact_of(const Sphere& sphere, const Triangle& triangle) {
  return contact_of(Capsule{sphere.center, sphere.center, sphere.radius}, triangle);
}
/// The contact of a hull that meets the triangle, given its parts. Empty if the deadline passed.
std::optional<ShapeContact> contact_of(const BodyParts& hull, const Triangle& triangle,
                                       const Deadline& deadline);

}  // namespace sightline

// Tests: tests/unit/geometry/shape_contact_test.cpp
