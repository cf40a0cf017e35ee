#pragma once
/// The three forms in which a kernel stores a ray, each with bounds of its rounding errors.
///
/// AnchoredRay   the ray o + t d from an origin near the scene, in float64: o + t d = origin + tau
///               * direction, up to `error` on each axis. tau is the ray's parameter in this form.
/// FilterRay     the AnchoredRay sheared so that its direction is an axis, for the triangle filter
/// BoxRay        the AnchoredRay in the units of one tree (wide_tree.h), in float32, for the slabs
///               of boxes
///
/// The anchor is the point of the ray that becomes the origin: the ray's own origin o if it is near
/// the scene, else a point of the ray near the scene.
///
/// docs/explanation/exactness.md proves the bounds.

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/bvh/scene_tree.h"
#include "core/query/ray_batch.h"
#include "core/trace/bounds.h"

namespace sightline {

/// 2^exponent. Precondition: it is a normal float64, as for scale_exponent of every tree.
inline double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
}

/// A closed interval that contains a number which is not known exactly.
struct Interval {
  double low = 0;
  double high = 0;
};

/// The first form.
struct AnchoredRay {
  std::array<double, 3> origin;
  std::array<double, 3>
      direction;     ///< a power of two times the ray's; the largest |component| is in [1, 2)
  double error = 0;  ///< at least |origin - (o + anchor * direction)| on every axis
  /// Minus the tau of the ray's own origin. No point of the scene within the limits has tau < 0,
  /// unless the anchor is unknown (NaN).
  double anchor = 0;
  double tau_per_t = 1;  ///< a power of two: tau = t * tau_per_t - anchor
  double reach =
      0;  ///< at least |v - origin| on every axis, for all points v of the scene, and 2^53 error
  Interval tau_min;  ///< interval that contains the tau of tmin
  Interval tau_max;  ///< interval that contains the tau of tmax; may be infinite

  /// An interval that contains the tau of every exact t that `t` approximates with a relative error
  /// of 2^-50 or an absolute error of 2^-1074.
  Interval tau_of(double t) const;
};

/// True if a component of `scaled`, which is `direction` times a power of two, may have lost bits
/// by underflow.
bool is_rounded(const Vec3d& direction, const std::array<double, 3>& scaled);

/// Makes the first form. `bounds` are the bounds of the scene's finite triangles. Preconditions:
/// the ray has passed check_rays, and the bounds are not empty.
AnchoredRay anchor_ray(const Ray& ray, const Box3d& bounds);

/// The second form (docs/explanation/exactness.md, "Triangles"). Axes are permuted so that the
/// direction's largest component is z.
struct FilterRay {
  double origin[3];         ///< AnchoredRay::origin on the axes kx, ky, kz
  double shear_x, shear_y;  ///< direction x / z and y / z
  double inverse_z;         ///< 1 / direction z: tau = z * inverse_z
  double reach;             ///< AnchoredRay::reach; every bound is a multiple of it
  double tau_min_low, tau_min_high, tau_max_low;  ///< ends of AnchoredRay::tau_min and tau_max
  /// The axes of the world that are x, y, z here.
  std::uint32_t kx, ky, kz;
};

/// Makes the second form.
FilterRay make_filter_ray(const AnchoredRay& ray);

/// The third form.
struct BoxRay {
  /// Sets octant and near_row. x, y, z: 1 if that component of the direction is negative, else 0.
  void set_octant(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    octant = x | y << 1 | z << 2;
    near_row = {24 * x, 8 + 24 * y, 16 + 24 * z};
  }
  static constexpr std::array<std::uint32_t, 3> kBothRows{24, 40, 56};  ///< near_row ^ far row

  /// In float32 arithmetic, for the planes where the ray enters and leaves a slab: tau_enter >=
  /// (plane - near_origin) * near_inverse and tau_leave <= (plane - far_origin) * far_inverse, if
  /// tau_enter, tau_leave >= 0. The fourth element exists for vector stores and is not read.
  std::array<float, 4> near_origin;
  std::array<float, 4> far_origin;
  std::array<float, 4> near_inverse;
  std::array<float, 4> far_inverse;
  std::uint32_t octant = 0;  ///< bit k: direction component k is negative (-0 counts)
  /// Offsets of the near planes of each axis in a WideNode, in float32 from its start. The far
  /// planes are at kBothRows ^ near_row, so no branch chooses between planes.
  std::array<std::uint32_t, 3> near_row{};
  float tau_min = 0;     ///< tree units, rounded down, not below 0
  double tau_scale = 1;  ///< tree tau = scene tau * tau_scale, a power of two

  /// A lower bound of the tree's tau for a tau of the scene, at least 0; NaN gives 0.
  static float lowest_tau(double scene_tau, double tau_scale) {
    const double tau = scene_tau * tau_scale;
    const double size = std::abs(tau);
    const auto low = static_cast<float>(tau - (size * bounds::kLimitStep + bounds::kLimitFloor));
    return low > 0 ? low : 0.0f;
  }
  /// An upper bound of the tree's tau for an upper bound of the scene's tau.
  float limit(double scene_tau) const { return limit(scene_tau, tau_scale); }
  static float limit(double scene_tau, double tau_scale) {
    const double tau = scene_tau * tau_scale;
    const double size = std::abs(tau);
    // A step up that is larger than the rounding error of float32, underflow included.
    const auto limit = static_cast<float>(tau + (size * bounds::kLimitStep + bounds::kLimitFloor));
    return limit == limit ? limit : std::numeric_limits<float>::infinity();
  }
};

/// Makes the third form for a tree whose boxes are in world units.
BoxRay make_box_ray(const AnchoredRay& ray, int scale_exponent);
/// Makes the third form for a tree in mesh units, entered through a placement.
BoxRay make_box_ray(const AnchoredRay& ray, const TreeSpace& space, int scale_exponent);

}  // namespace sightline

// Tests: tests/unit/trace/kernel_test.cpp
