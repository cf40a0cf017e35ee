#pragma once
/// How far a segment or a triangle is from a triangle, exactly.
///
/// Method   0 if an edge of one goes through the other; else the nearest points are a corner of one
///          and a point of the other, or lie inside of two edges. Each of these has a squared
///          distance that is a ratio of polynomials of degree six and four (point_triangle.h).
/// Filter   float64 gives an interval that contains the distance, and leaves out what cannot be
/// nearest.
/// Proofs   docs/explanation/exactness-points.md.

#include <span>

#include "core/geometry/point_triangle.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// One, two or three finite corners: a point, a segment, a triangle. All may coincide.
using Corners = std::span<const Vec3d>;
inline Corners corners_of(const Triangle& t) { return {&t.v0, 3}; }

/// The range is within 512 * 2^-53 of the largest extent of the two triangles in total, plus the
/// error of a badly chosen pair of points. It is everything where magnitudes exceed 2^400 or are
/// below 2^-400.
DistanceRange distance_range(Corners a, Corners b);

/// Preconditions: `a` has two corners, or three with an area; `b` has an area.
ExactDistance exact_distance(Corners a, const Triangle& b);

/// A point of each that are as near as any, every coordinate correctly rounded; where they meet, a
/// point that both have. The same precondition.
struct NearestPair {
  Vec3d on_a, on_b;
};
NearestPair nearest_pair(Corners a, const Triangle& b);

}  // namespace sightline

// Tests: tests/unit/trace/clearance_test.cpp
