#pragma once
/// The distance of a point from a closed triangle, exactly.
///
/// Method   the nearest point of a triangle is a corner, inside of an edge, or inside of the
///          triangle. Signs decide which: for each edge, where along the edge the point lies, and
///          on which side of the edge [Ericson2005]. The squared distance is then a ratio of
///          polynomials of degree at most six and four.
/// Filter   float64 gives an interval that contains the distance. Only distances whose intervals
///          overlap are compared as ratios, in Dyadic numbers.
/// Proofs   docs/explanation/exactness-points.md.
///
/// Preconditions of all functions here: the point and the corners are finite, the triangle has an
/// area.

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/exact_hit.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// An interval [low, high] that contains a distance, in scene units.
struct DistanceRange {
  double low = 0;
  double high = 0;
};

/// An interval that contains the distance, by float64 arithmetic. Let size be the largest magnitude
/// of a coordinate of a corner relative to the point. The width of the interval is at most 128 *
/// 2^-53 times size. The interval is [0, inf] if size is at least 2^400 or below 2^-400.
DistanceRange distance_range(const Vec3d& point, const Triangle& triangle);

/// The corner (one bit) or the edge (the bits of both ends) on which the nearest point lies, if
/// float64 arithmetic proves it; else 0. If two triangles have the same corner or edge as their
/// result (corners_at), they are at the same distance.
CornerSet certain_nearest_edge(const Vec3d& point, const Triangle& triangle);

/// The exact distance of a point and a triangle, sqrt(square / divisor), as two exact numbers.
struct ExactDistance {
  Dyadic square;        ///< the square of the distance times `divisor`
  Dyadic divisor{1.0};  ///< positive

  /// The distance rounded once to the nearest float64; +inf beyond the largest float64.
  double rounded() const { return round_root(square, divisor); }
};
/// The distance of a point and a triangle.
ExactDistance exact_distance(const Vec3d& point, const Triangle& triangle);
/// The distance of a point whose coordinates are Dyadic numbers.
ExactDistance exact_distance(const DyadicVector& point, const Triangle& triangle);
/// A vector from the nearest point of the triangle to the point, of some length; zero if the point
/// is on the triangle.
DyadicVector away_from(const Triangle& triangle, const Vec3d& point);

/// Sign of a - b, exactly: -1, 0 or 1.
int compare(const ExactDistance& a, const ExactDistance& b);
/// Sign of a - distance, exactly. Precondition: `distance` is not negative and not NaN.
int compare(const ExactDistance& a, double distance);

/// Properties of the nearest point of the triangle, each number correctly rounded.
struct NearestDetail {
  /// detail.front: the query point lies strictly on the side of the triangle's plane from which the
  /// corners run counter-clockwise
  ExactDetail detail;
  bool on_edge = false;  ///< the nearest point is exactly on an edge or a corner
};
/// The properties of the point of the triangle that is nearest to `point`.
NearestDetail nearest_detail(const Vec3d& point, const Triangle& triangle);
NearestDetail nearest_detail(const DyadicVector& point, const Triangle& triangle);

}  // namespace sightline
