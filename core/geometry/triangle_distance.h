#pragma once
/// The distance between a segment or triangle and another triangle, exactly.
///
/// Method   the distance is 0 if an edge of one passes through the other. Otherwise the nearest
///          points are either a corner of one and a point of the other, or points inside of two
///          edges. Each of these pairs has a squared distance that is a ratio of polynomials of
///          degree six and four (point_triangle.h).
/// Filter   float64 gives an interval that contains the distance, and excludes pairs that cannot be
///          the nearest.
/// Proofs   docs/explanation/exactness-points.md.

#include <span>

#include "core/geometry/point_triangle.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The corners of a shape: one for a point, two for a segment, three for a triangle. They are
/// finite; some or all may be equal. The span views memory of the caller.
using Corners = std::span<const Vec3d>;
/// The corners of a triangle, which must outlive the result.
inline Corners corners_of(const Triangle& t) { return {&t.v0, 3}; }

/// An interval that contains the distance, by float64 arithmetic. Let size be the largest magnitude
/// of a coordinate of a corner of `a` or `b`, relative to the first corner of `b`. The width of the
/// interval is at most 512 * 2^-53 times size, plus the error of a pair of points that rounding
/// chose wrongly. The interval is [0, inf] if size is at least 2^400 or below 2^-400.
DistanceRange distance_range(Corners a, Corners b);

/// The exact distance. Preconditions: `a` has two corners, or three with an area; `b` has an area;
/// all corners are finite.
ExactDistance exact_distance(Corners a, const Triangle& b);

/// A vector from the point of `b` that is nearest to `a` to the point of `a` that is nearest to
/// `b`, of some length. All nearest pairs have the same. Preconditions: those of exact_distance,
/// and the distance is not 0.
DyadicVector away_from(const Triangle& b, Corners a);

/// The points of `a` and `b` that are nearest to each other, each coordinate correctly rounded. If
/// several pairs are nearest, it is one of them. If the shapes meet, both are a common point.
/// Preconditions: those of exact_distance.
struct NearestPair {
  Vec3d on_a, on_b;
};
NearestPair nearest_pair(Corners a, const Triangle& b);

}  // namespace sightline

// Tests: tests/unit/trace/clearance_test.cpp
