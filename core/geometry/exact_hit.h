#pragma once
/// Ray against triangle in exact arithmetic: the truth behind every filter.
///
/// With A, B, C the corners seen from the origin and d the direction, the signs of
///     w0 = d.(B x C)   w1 = d.(C x A)   w2 = d.(A x B)
/// decide: the line meets the closed triangle if none of them disagrees, and then
///     t = A.(B x C) / (w0 + w1 + w2).
/// Their sum is d.n with the normal n = (v1-v0) x (v2-v0). If it is zero although no two signs
/// disagree, all three are zero and the line lies in the triangle's plane: then t is where the line
/// enters the triangle (docs/reference/contract.md, "The answers").

#include <cstdint>
#include <optional>

#include "core/geometry/dyadic.h"
#include "core/geometry/fixed_point.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// An exact ray parameter numerator / denominator; the denominator is positive.
struct ExactT {
  Dyadic numerator;
  Dyadic denominator{1.0};

  double rounded() const { return round_quotient(numerator, denominator); }
  /// Within 2^-50 of t or 2^-1074, whichever is more.
  double approximate() const { return approximate_quotient(numerator, denominator); }
};

/// Sign of a - b.
int compare(const ExactT& a, const ExactT& b);
/// Sign of t - limit; the limit may be infinite.
int compare(const ExactT& t, double limit);

/// The least real t in [tmin, tmax] with origin + t * direction on the triangle. Returns false, and
/// leaves t unspecified, if there is none, if the triangle has exactly no area, or if a corner is
/// not finite. Preconditions: origin and direction finite, direction not zero, limits not NaN.
bool exact_hit(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
               const Triangle& triangle, ExactT& t);

/// Integers that exact_hit and met_edge share for one ray and triangle. Empty if the numbers do not
/// fit, or a corner is not finite.
using SharedHit = std::optional<FixedHit>;
SharedHit shared_hit(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle);
bool exact_hit(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
               const Triangle& triangle, const SharedHit& shared, ExactT& t);

/// Corners of a triangle, bit i for corner i.
using CornerSet = std::uint32_t;

/// On which corner or edge the line meets the triangle: one corner, or the two ends of an edge. 0
/// if it misses, passes through the inside, lies in the plane, or the numbers do not fit integers
/// of 256 bits. Preconditions as above.
CornerSet met_edge(const SharedHit& shared);

/// Whether these corners of `a` are, number by number, those of `b`. What a line meets there is
/// then one point with one t.
bool same_corners(const Triangle& a, CornerSet in_a, const Triangle& b, CornerSet in_b);

/// Whether the line crosses the triangle properly after the origin is displaced by an infinitely
/// small (e, e^2, e^3), e > 0. The direction does not change. The displaced line meets no edge, no
/// corner and no plane that it is parallel to. So on a closed mesh it crosses an even number of
/// triangles, and triangles that share an edge or a corner agree on which of them is crossed. The
/// line itself meets every triangle that the displaced line crosses. The reverse holds except at
/// edges and corners and in the plane. Source: [Edelsbrunner1990], applied to the ray alone.
bool exact_crossing(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle);

/// Whether the point of the triangle at t lies on one of its edges, corners included, exactly.
/// Precondition: exact_hit gave t for the same ray and triangle.
bool is_on_edge(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle,
                const ExactT& t);

/// Sign of direction . normal, exactly: -1 where the counter-clockwise side is met, 0 in the plane
/// or parallel to it. Preconditions: all finite.
int side_sign(const Vec3d& direction, const Triangle& triangle);

/// Whether the triangle has exactly no area.
bool is_degenerate(const Triangle& triangle);

/// The properties of a hit. HitDetail states their accuracy. Precondition: exact_hit gave t for
/// this ray and triangle.
struct ExactDetail {
  Vec3d position;  ///< each coordinate correctly rounded
  Vec3d normal;    ///< each component of n / |n| correctly rounded
  double u = 0;    ///< correctly rounded
  double v = 0;    ///< correctly rounded
  bool front = true;
};
ExactDetail exact_detail(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle,
                         const ExactT& t);

}  // namespace sightline
