#pragma once
/// Rays as columns, and the check at the border that all of them pass before anything is traced.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/column.h"
#include "core/base/result.h"
#include "core/geometry/vec3.h"

namespace sightline {

/// One ray: the points origin + t * direction with tmin <= t <= tmax, exactly the float64 numbers
/// that were received. The direction is never normalised; t counts in |direction|.
struct Ray {
  Vec3d origin;
  Vec3d direction;
  double tmin = 0;
  double tmax = std::numeric_limits<double>::infinity();
};

/// n rays as eight columns of n float64 numbers, scene units, and perhaps one of masks.
struct RayBatch {
  UnsetColumn<double> ox, oy, oz, dx, dy, dz, tmin, tmax;
  /// Which instances each ray may meet: those with a bit in common. Empty: all of them.
  Column<std::uint32_t> mask = {};

  std::size_t size() const { return ox.size(); }
  void reserve(std::size_t count);
  /// New rays have no limits, and origins and directions that are not set.
  void resize(std::size_t count);
  void push_back(const Ray& ray);
  Ray operator[](std::size_t i) const {
    return {{ox[i], oy[i], oz[i]}, {dx[i], dy[i], dz[i]}, tmin[i], tmax[i]};
  }
};

/// The place of a bad ray in a batch, for the codec to turn into a JSON pointer.
struct RayFault {
  std::size_t ray = 0;
  const char* part = "";  ///< "origin", "direction", "tmin" or "tmax"
  const char* code =
      "";  ///< RAY_NOT_FINITE, RAY_DIRECTION_ZERO, RAY_LIMIT_NAN, RAY_LIMITS_REVERSED
  const char* message = "";
};

/// The border: after it the inside trusts the rays. Finds the first ray with a non-finite origin or
/// direction, a direction of exactly zero, a NaN limit, or tmin > tmax. Infinite limits are
/// allowed. Returns true and leaves `fault` alone when every ray is good.
bool check_rays(const RayBatch& rays, RayFault& fault);

/// The bad rays of a batch.
struct InvalidRays {
  Column<std::size_t> number;  ///< ascending
  std::vector<const char*> code;
};

/// check_rays for batches whose good rays are answered despite bad ones. Replaces each bad ray by a
/// ray that meets nothing, and returns their numbers.
InvalidRays replace_invalid(RayBatch& rays);

/// t * |direction|, what t is in scene units, within 2^-51 of itself whatever the scale (unless it
/// underflows). Precondition: the direction is finite and not zero. An infinite t stays so.
double distance_of(double t, const Vec3d& direction);

/// Turns limits that count in scene units into limits of t: divides each by |direction|, with the
/// same accuracy.
void scale_limits_to_t(RayBatch& rays);

}  // namespace sightline
