#pragma once
/// RayBatch: rays as columns, and check_rays, the validation that all rays pass before they are
/// traced.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/column.h"
#include "core/base/result.h"
#include "core/geometry/vec3.h"

namespace sightline {

/// A ray: the points origin + t * direction with tmin <= t <= tmax, with exactly the float64
/// numbers of the client. The direction is never normalised, so t is in units of |direction|.
struct Ray {
  Vec3d origin;
  Vec3d direction;
  double tmin = 0;
  double tmax = std::numeric_limits<double>::infinity();
};

/// n rays as eight columns of n float64 numbers, in scene units, and optionally a column of masks.
/// Fill the columns or call push_back(), then call check_rays.
struct RayBatch {
  UnsetColumn<double> ox, oy, oz, dx, dy, dz, tmin, tmax;
  /// The mask of each ray: it meets only instances whose mask shares a bit with it. Masks take
  /// effect only through a filter of resolve_for_rays (core/run/resolved_filter.h). Empty: rays
  /// meet all instances; else n masks. The functions below do not change it.
  Column<std::uint32_t> mask = {};

  std::size_t size() const { return ox.size(); }
  /// Allocates memory for `count` rays. Throws std::bad_alloc, as do resize() and push_back().
  void reserve(std::size_t count);
  /// Sets the number of rays. New rays have tmin 0 and tmax +inf; their origins and directions are
  /// uninitialised.
  void resize(std::size_t count);
  /// Appends a ray without a mask.
  void push_back(const Ray& ray);
  /// Overwrites ray i. Precondition: i < size().
  void set(std::size_t i, const Ray& ray) {
    ox[i] = ray.origin.x;
    oy[i] = ray.origin.y;
    oz[i] = ray.origin.z;
    dx[i] = ray.direction.x;
    dy[i] = ray.direction.y;
    dz[i] = ray.direction.z;
    tmin[i] = ray.tmin;
    tmax[i] = ray.tmax;
  }
  /// Returns ray i. Precondition: i < size().
  Ray operator[](std::size_t i) const {
    return {{ox[i], oy[i], oz[i]}, {dx[i], dy[i], dz[i]}, tmin[i], tmax[i]};
  }
};

/// The first invalid ray of a batch. The texts are constants, valid for ever.
struct RayFault {
  std::size_t ray = 0;
  const char* part = "";  ///< "origin", "direction", "tmin" or "tmax"
  /// RAY_NOT_FINITE, RAY_DIRECTION_ZERO, RAY_LIMIT_NAN or RAY_LIMITS_REVERSED
  const char* code = "";
  /// One sentence for people.
  const char* message = "";
};

/// Validates rays of clients; every function that traces rays trusts them. Finds the first ray with
/// a non-finite origin or direction, a direction of exactly zero, a NaN limit, or tmin > tmax.
/// Infinite limits are valid. Returns true, and does not set `fault`, if every ray is valid.
bool check_rays(const RayBatch& rays, RayFault& fault);

/// The invalid rays of a batch.
struct InvalidRays {
  Column<std::size_t> number;  ///< indices of the rays, ascending
  /// The code (RayFault::code) of each of them.
  std::vector<const char*> code;
};

/// check_rays for a batch whose valid rays are answered despite invalid ones. Replaces each invalid
/// ray by a ray that meets nothing, and returns the replaced rays. Throws std::bad_alloc.
InvalidRays replace_invalid(RayBatch& rays);

/// Returns t * |direction|: the distance of t in scene units, with the sign of t. The relative
/// error is at most 2^-51 whatever the scale, unless the result underflows. An infinite t stays
/// infinite. Precondition: the direction is finite and not zero.
double distance_of(double t, const Vec3d& direction);

/// Converts tmin and tmax from scene units to units of t: divides each by |direction|, with the
/// accuracy of distance_of. Precondition: that of distance_of for every ray.
void scale_limits_to_t(RayBatch& rays);

}  // namespace sightline
