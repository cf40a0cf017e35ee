#pragma once
/// Ray against triangle in exact arithmetic. These functions define the answers; every faster
/// filter must agree with them.
///
/// The line is the set of all points origin + t * direction, for all real t. Let A, B, C be the
/// triangle's corners v0, v1, v2 minus the ray's origin, and d its direction. The signs of
///     w0 = d.(B x C)   w1 = d.(C x A)   w2 = d.(A x B)
/// decide: the line meets the closed triangle if no two of them are of opposite sign, and then
///     t = A.(B x C) / (w0 + w1 + w2).
/// The denominator w0 + w1 + w2 is d.n with the normal n = (v1-v0) x (v2-v0). If it is zero
/// although no two signs are opposite, then all three are zero and the line lies in the triangle's
/// plane. In that case t is where the line enters the triangle (docs/reference/contract.md, "The
/// answers").

#include <cstdint>
#include <optional>

#include "core/geometry/dyadic.h"
#include "core/geometry/fixed_point.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// An exact ray parameter t, a ratio of two exact numbers: integers of 256 bits from fixed_hit, or
/// Dyadic. An object takes 18 KB, of which only the form in use is written or copied. Unspecified
/// until it is set.
class ExactT {
 public:
  ExactT() = default;
  /// Precondition of both: the denominator is not zero.
  ExactT(const Dyadic& numerator, const Dyadic& denominator)
      : numerator_(numerator), denominator_(denominator) {}
  ExactT& operator=(const FixedT& t) {
    fixed_ = t;
    is_fixed_ = true;
    return *this;
  }

  /// The terms of the ratio; the denominator is positive.
  Dyadic numerator() const;
  Dyadic denominator() const;
  /// -1, 0 or 1.
  int sign() const;
  /// t rounded once to float64.
  double rounded() const;
  /// t with an error of at most 2^-50 |t| or 2^-1074, whichever is more.
  double approximate() const;

 private:
  FixedT fixed_;
  bool is_fixed_ = false;
  Dyadic numerator_, denominator_;  ///< unless is_fixed_
};

/// Sign of a - b, exactly: -1, 0 or 1.
int compare(const ExactT& a, const ExactT& b);
/// Sign of t - limit, exactly; the limit may be infinite, but not NaN.
int compare(const ExactT& t, double limit);

/// Finds the least real number in [tmin, tmax] at which origin + t * direction is on the closed
/// triangle, and writes it to `t`. Returns false, and leaves `t` unspecified, if there is no such
/// number, if the triangle has exactly no area, or if a corner is not finite. Preconditions: origin
/// and direction are finite, direction is not zero, limits are not NaN.
bool exact_hit(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
               const Triangle& triangle, ExactT& t);

/// A set of corners of a triangle: bit i is set for corner i.
using CornerSet = std::uint32_t;

/// The integers of fixed_point.h for one ray and triangle. Empty if the coordinates do not fit the
/// grid of fixed_point.h, or if a corner is not finite. Preconditions: those of exact_hit for the
/// ray.
using SharedHit = std::optional<FixedHit>;
SharedHit shared_hit(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle);

/// Where a line meets a triangle.
struct ExactHit {
  ExactT t;
  /// The corner (one bit) or the edge (the bits of both ends) in which it meets the triangle at t. 0
  /// for another point, and if shared_hit is empty.
  CornerSet edge = 0;
};
/// exact_hit for a ray and triangle whose shared_hit is known. Without a hit, `hit` is unspecified.
bool exact_hit(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
               const Triangle& triangle, const SharedHit& shared, ExactHit& hit);

/// The corners of `a` that have the coordinates of the corners `in_b` of `b`; 0 if one of those has
/// none. A line that meets `b` in this edge or corner also meets `a` in it. Its t is equal for both,
/// unless the line lies in the plane of `a`.
CornerSet corners_at(const Triangle& a, const Triangle& b, CornerSet in_b);

/// True if the line, without limits of t, crosses the triangle properly after its origin is
/// displaced by (e, e^2, e^3) for an infinitely small e > 0. The direction does not change. The
/// displaced line meets no edge, no corner, and no plane to which it is parallel. So it crosses a
/// closed mesh an even number of times, and triangles that share an edge or a corner agree on which
/// of them is crossed. The original line meets every triangle that the displaced line crosses; the
/// reverse holds except at edges, at corners and in the triangle's plane. False for a triangle that
/// has exactly no area or a corner that is not finite. Preconditions: origin and direction are
/// finite, direction is not zero. Source: [Edelsbrunner1990], applied to the ray alone.
bool exact_crossing(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle);

/// True if the point of the line at t is exactly on an edge or corner of the triangle.
/// Precondition: exact_hit gave t for the same ray and triangle.
bool is_on_edge(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle,
                const ExactT& t);

/// Sign of direction . normal, exactly: -1 if the line comes from the side on which the corners run
/// counter-clockwise, +1 if it comes from the other side, 0 if it is parallel to the plane.
/// Precondition: all numbers are finite.
int side_sign(const Vec3d& direction, const Triangle& triangle);

/// side_sign by rounded numbers: -1 and +1 are certain, 0 says nothing. Cost: some nanoseconds.
int certain_side_sign(const Vec3d& direction, const Triangle& triangle);

/// True if the triangle has exactly no area. Precondition: the corners are finite.
bool is_degenerate(const Triangle& triangle);

/// n / |n| with n = (v1-v0) x (v2-v0), each component correctly rounded. Preconditions: all numbers
/// are finite, and the triangle is not degenerate.
Vec3d exact_normal(const Triangle& triangle);

/// Properties of the point at which a ray hits a triangle, or of the nearest point
/// (point_triangle.h).
struct ExactDetail {
  Vec3d position;     ///< each coordinate correctly rounded
  Vec3d normal;       ///< exact_normal
  double u = 0;       ///< barycentric weight of v1, correctly rounded
  double v = 0;       ///< barycentric weight of v2, correctly rounded
  bool front = true;  ///< the ray comes from the side on which the corners run counter-clockwise
};
/// The properties of the point at t. Precondition: exact_hit gave t for the same ray and triangle.
ExactDetail exact_detail(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle,
                         const ExactT& t);

}  // namespace sightline
