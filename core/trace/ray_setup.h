#pragma once
/// What a kernel keeps of a ray: three views of it, each with its error bounded.
///
///   AnchoredRay   the ray from a near origin, float64: o + t d = origin + tau * direction, up to
///                 `error` on each axis
///   FilterRay     the same, sheared so that the direction is an axis, for the triangle filter
///   BoxRay        the same in the units of one tree, float32, for the slabs of its boxes
///
/// Proofs are in docs/exactness.md; the numbers there are the numbers here.

#include <array>
#include <cstdint>

#include "core/bvh/scene_tree.h"
#include "core/query/ray_batch.h"

namespace sightline {

/// A closed range that contains a number which is not known exactly.
struct Interval {
  double low = 0;
  double high = 0;
};

struct AnchoredRay {
  std::array<double, 3> origin;
  std::array<double, 3>
      direction;      ///< a power of two times the ray's; the largest |component| is in [1, 2)
  double error = 0;   ///< on every axis at least |origin - (o + anchor * d)|
  double anchor = 0;  ///< t at which tau = 0. No point of the scene within the limits has tau < 0
  double tau_per_t = 1;  ///< a power of two: tau = (t - anchor) * tau_per_t
  double reach =
      0;  ///< at least |v - origin| on every axis, for all points v of the scene, and 2^53 error
  Interval tau_min;  ///< contains the tau of tmin
  Interval tau_max;  ///< contains the tau of tmax; may be infinite

  /// Contains the tau of every t that rounds to `rounded_t`.
  Interval tau_of(double rounded_t) const;
};

/// `bounds` of the scene's finite triangles, not empty. The ray has passed check_rays.
AnchoredRay anchor_ray(const Ray& ray, const Box3d& bounds);

/// The filter of docs/exactness.md, "Triangles": axes permuted so that z is the direction's
/// largest.
struct FilterRay {
  std::uint32_t kx = 0, ky = 1, kz = 2;
  double shear_x = 0, shear_y = 0;  ///< direction x / z and y / z
  double inverse_z = 0;             ///< 1 / direction z: tau = z * inverse_z
  double sign_factor = 0;           ///< E = sign_factor * (m + sign_offset) + kSignFloor
  double sign_offset = 0;
  double t_base = 0;  ///< 16 u reach: half the width of z at best
};

/// Below it a bound could be spoilt by underflow; such lanes go to the exact stage.
inline constexpr double kSignFloor = 0x1p-960;

FilterRay make_filter_ray(const AnchoredRay& ray);

struct BoxRay {
  /// For the plane where the ray enters a slab and the one where it leaves:
  /// tau_enter >= (plane - near_origin) * near_inverse, tau_leave <= (plane - far_origin) *
  /// far_inverse as float32 arithmetic computes them, whenever tau_enter, tau_leave >= 0.
  std::array<float, 3> near_origin;
  std::array<float, 3> far_origin;
  std::array<float, 3> near_inverse;
  std::array<float, 3> far_inverse;
  std::uint32_t octant = 0;  ///< bit k: direction component k is negative (-0 counts)
  float tau_min = 0;         ///< tree units, rounded down, not below 0
  double tau_scale = 1;      ///< tree tau = scene tau * tau_scale, a power of two

  /// An upper bound for tree tau that has the scene's upper bound.
  float limit(double scene_tau) const;
};

/// For a tree whose boxes are in world units.
BoxRay make_box_ray(const AnchoredRay& ray, int scale_exponent);
/// For a tree in mesh units, entered through a placement.
BoxRay make_box_ray(const AnchoredRay& ray, const TreeSpace& space, int scale_exponent);

}  // namespace sightline
