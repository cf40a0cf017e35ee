#pragma once
/// Closed triangle against an intersection of closed half-spaces, exactly: touching counts.
///
/// Method   the triangle is clipped by one plane after the other. A clipped polygon's corners are
///          crossings of two of the given lines, stored as barycentric weights up to a common
///          factor: cross products of two rows of values that the corners have on two planes. So
///          numbers never grow beyond degree six, however many planes there are.
/// Filter   float64: all corners beyond one plane, or one corner within all of them.
/// Proofs   docs/explanation/exactness-boxes.md.

#include <span>

#include "core/geometry/triangle.h"

namespace sightline {

/// The points p with normal . p <= offset, in real arithmetic: nothing is normalised. Finite, and
/// the normal is not zero.
struct HalfSpace {
  Vec3d normal;
  double offset = 0;
};

/// An intersection of closed half-spaces: a view frustum, any convex polyhedron, bounded or not,
/// maybe empty.
struct ConvexRegion {
  static constexpr std::size_t kMostPlanes = 32;

  std::span<const HalfSpace> planes;
};

/// Whether they have a point in common. False for a triangle that has exactly no area or a corner
/// that is not finite, as of boxes (triangle_box.h). Throws std::bad_alloc.
bool triangle_meets_box(const Triangle& triangle, const ConvexRegion& region);

/// Sign of normal . p - offset.
int side_of(const HalfSpace& plane, const Vec3d& p);

}  // namespace sightline

// Tests: tests/unit/query/box_batch_test.cpp
