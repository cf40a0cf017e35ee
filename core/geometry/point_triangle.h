#pragma once
/// How far a point is from a closed triangle, exactly.
///
/// Method   the nearest point of a triangle lies on a corner, inside an edge or inside the
///          triangle. Signs decide which: of the two ends of each edge along it, and of the
///          edge's side [Ericson2005]. The squared distance is then a ratio of polynomials, of
///          degree six and four at most.
/// Filter   float64 gives an interval that contains the distance; only intervals that overlap are
///          compared as ratios, in Dyadic numbers.
/// Proofs   docs/explanation/exactness-points.md.
///
/// Preconditions of all: the point and the corners are finite, the triangle has an area.

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/exact_hit.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// Contains a distance, in scene units.
struct DistanceRange {
  double low = 0;
  double high = 0;
};

/// Within 128 * 2^-53 of the farthest coordinate from each other, or everything where magnitudes
/// pass 2^400 or fall below 2^-400.
DistanceRange distance_range(const Vec3d& point, const Triangle& triangle);

/// On which corner, or inside of which edge (its two ends), the nearest point lies, if float64 can
/// be certain of it; else 0. Two triangles that share it (same_corners) are at the same distance.
CornerSet certain_nearest_edge(const Vec3d& point, const Triangle& triangle);

/// sqrt(square / divisor); the divisor is positive.
struct ExactDistance {
  Dyadic square;
  Dyadic divisor{1.0};

  /// The distance rounded once to the nearest float64; +inf beyond the largest.
  double rounded() const { return round_root(square, divisor); }
};
ExactDistance exact_distance(const Vec3d& point, const Triangle& triangle);
/// As exact_distance of a float64 point, for a point of exact numbers.
ExactDistance exact_distance(const DyadicVector& point, const Triangle& triangle);

/// Sign of a - b.
int compare(const ExactDistance& a, const ExactDistance& b);
/// Compares an exact distance with a float64 distance. Precondition: `distance` is not negative and
/// not NaN.
int compare(const ExactDistance& a, double distance);

/// The nearest point of the triangle, every number of it correctly rounded. detail.front: the point
/// lies strictly on the counter-clockwise side of the triangle's plane.
struct NearestDetail {
  ExactDetail detail;
  bool on_edge = false;  ///< it lies on an edge or a corner, exactly
};
NearestDetail nearest_detail(const Vec3d& point, const Triangle& triangle);
NearestDetail nearest_detail(const DyadicVector& point, const Triangle& triangle);

}  // namespace sightline
