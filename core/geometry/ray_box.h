#pragma once
/// Ray against closed box: the slab test [Kay1986], decided exactly.
///
/// The line is all points origin + t * direction; the ray is the part with tmin <= t <= tmax. Slab
/// k is the set of points between the lower and the upper plane of axis k. The line enters slab k
/// at t_near(k) and leaves it at t_far(k). Both are quotients of numbers that are exact sums or
/// products of the input. The line is in the box from the largest t_near to the smallest t_far.
///
/// Stages  Every comparison of two quotients first compares their float64 values. For an
///         axis-aligned plane T = (plane - origin) / d, computed as t with two roundings, satisfies
///             |t - T| <= (2u + u^2) |T| + 2^-1074,   u = 2^-53.
///         So two of them (or one and a limit) that differ by more than
///         2^-51 (|T1| + |T2|) + 2^-1072 are ordered by their float64 values. Closer ones are
///         decided by products without error, and what those leave open by Dyadic numbers.
///         Oriented boxes start with double-double values whose error is bounded as they are
///         summed.
/// Rounding  t is rounded once. plane - origin often is a float64 number; then one division rounds
///         once. Else the quotient is refined to 100 bits, and accepted if its whole error interval
///         rounds to one number. Else Dyadic numbers decide.
/// Proofs  docs/explanation/exactness-boxes.md.

#include <array>
#include <cstdint>
#include <optional>

#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/vec3.h"

namespace sightline {

/// Whether a ray meets a box, and why not.
enum class RayBoxOutcome : std::uint8_t {
  kHit,     ///< some point origin + t * direction, tmin <= t <= tmax, is in the box
  kApart,   ///< a miss: one slab is left before another is entered
  kBeside,  ///< a miss: the ray runs parallel to a slab, outside it
  kBehind,  ///< the line meets the box, but leaves it before tmin
  kBeyond,  ///< the line meets the box, but enters it after tmax
};

/// One face of a box: `upper` or lower plane of slab `axis`. The lower plane of an oriented box is
/// where axes[axis] . (p - center) = -half[axis].
struct BoxFace {
  std::uint8_t axis = 0;
  bool upper = false;
  bool operator==(const BoxFace&) const = default;
};

/// A list of up to six faces: face[0] .. face[count - 1].
struct BoxFaces {
  std::uint8_t count = 0;
  std::array<BoxFace, 6> face{};
  /// Precondition: count < 6.
  constexpr void add(BoxFace f) { face[count++] = f; }
};

/// The result of ray_box. t is a ray parameter, in units of |direction|.
struct RayBoxAnswer {
  RayBoxOutcome outcome = RayBoxOutcome::kApart;
  bool inside = false;      ///< the origin (t = 0) lies in the interior
  bool on_surface = false;  ///< the origin lies in the box, but not in its interior
  /// Set for kApart: the slab that is entered last and the slab that is left first, which exclude
  /// each other; the smaller axis first. Set for kBeside: the first slab that the ray runs outside
  /// of, twice. Axes are 0, 1, 2.
  std::array<std::uint8_t, 2> apart{};
  /// Where the line enters and leaves the box, each rounded once; zero is +0. Infinite where the
  /// box is open, or where a finite t rounds to infinity. Set for kHit, kBehind and kBeyond, else
  /// 0.
  double t_enter = 0;
  double t_exit = 0;
  /// For a hit: t of the reported point of the surface, else 0. The first rule that applies
  /// decides:
  ///   0        the origin lies on the surface, and tmin <= 0 <= tmax
  ///   t_exit   the origin lies in the interior, and the exit is not after tmax
  ///   t_enter  the entry is not before tmin
  ///   t_exit   the exit is not after tmax
  ///   +inf     otherwise: [tmin, tmax] lies in the interior, and `faces` is empty
  double t = 0;
  /// For a hit: every face that contains the point at t, edges and corners included. First come the
  /// faces that the ray crosses there on its way in (on its way out if t is the exit of an origin
  /// inside). Then come faces that it crosses the other way, then faces that it runs along. Each
  /// group is in the order x, y, z. The normal that is reported belongs to the first face.
  BoxFaces faces;
};

/// Tests the part tmin <= t <= tmax of a ray against a box.
/// Law     exact: the answer is that of real arithmetic over the given float64 numbers.
/// Preconditions: origin and direction are finite, direction is not zero, limits are not NaN, tmin
/// <= tmax; box.min <= box.max on every axis, min < +inf, max > -inf.
RayBoxAnswer ray_box(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
                     const Box3d& box);
/// The test for an oriented box. Preconditions: those above for the ray; center and axes are
/// finite, half is not negative and not NaN.
RayBoxAnswer ray_box(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
                     const OrientedBox& box);

/// The t at which the line crosses the six planes of a box, in the order -x +x -y +y -z +z, each
/// rounded once. For an oriented box, x, y, z are axes[0], axes[1], axes[2]. An element is empty if
/// the line is parallel to the plane, or if the box is open there. Preconditions: those of ray_box.
using PlaneTs = std::array<std::optional<double>, 6>;
PlaneTs ray_box_planes(const Vec3d& origin, const Vec3d& direction, const Box3d& box);
PlaneTs ray_box_planes(const Vec3d& origin, const Vec3d& direction, const OrientedBox& box);

/// The outward unit normal of a face; for an oriented box each component is within 1e-15.
Vec3d face_normal(const Box3d& box, BoxFace face);
Vec3d face_normal(const OrientedBox& box, BoxFace face);

}  // namespace sightline
