#pragma once
/// Closed triangle against an intersection of closed half-spaces, exactly: touching counts.
///
/// Method   clips the triangle by one plane after the other. A corner of a clipped polygon is the
///          crossing of two lines. It is stored as barycentric weights up to a common factor
///          (clip_triangle.h). These are the cross product of the two rows of values that the
///          triangle's corners have on the planes. So degrees never exceed six, however many planes
///          there are.
/// Filter   float64. It decides if all corners are beyond one plane, or one corner is within all
///          planes.
/// Proofs   docs/explanation/exactness-boxes.md.

#include <span>

#include "core/geometry/triangle.h"

namespace sightline {

/// The points p with normal . p <= offset, in real arithmetic. The normal points out of the
/// half-space and need not be of unit length. All numbers are finite, and the normal is not zero.
struct HalfSpace {
  Vec3d normal;
  double offset = 0;
};

/// An intersection of closed half-spaces: a view frustum or any other convex polyhedron. It may be
/// unbounded or empty. It stores no planes: the array that `planes` views must outlive it.
struct ConvexRegion {
  /// The most planes that check_boxes (core/query/box_batch.h) accepts.
  static constexpr std::size_t kMostPlanes = 32;

  std::span<const HalfSpace> planes;
};

/// True if triangle and region have at least one point in common. False for a triangle that has
/// exactly no area or a corner that is not finite. Throws std::bad_alloc.
bool triangle_meets_box(const Triangle& triangle, const ConvexRegion& region);

/// Sign of normal . p - offset, exactly: -1 inside of the half-space, 0 on its plane, +1 outside.
/// Precondition: p is finite.
int side_of(const HalfSpace& plane, const Vec3d& p);

}  // namespace sightline

// Tests: tests/unit/query/box_batch_test.cpp
