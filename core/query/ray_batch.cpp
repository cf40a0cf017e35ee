#include "core/query/ray_batch.h"

#include <cmath>

namespace sightline {

namespace {

/// part * 2^exponent, with 1 <= part < 4: beyond the range of float64 too.
struct Length {
  double part = 1;
  int exponent = 0;
};

/// Within one unit in the last place.
Length length_of(const Vec3d& direction) {
  const double largest =
      std::fmax(std::fabs(direction.x), std::fmax(std::fabs(direction.y), std::fabs(direction.z)));
  const int exponent = std::ilogb(largest);
  double sum = 0, rest = 0;
  for (int k = 0; k < 3; ++k) {
    const double c = std::scalbn(direction[k], -exponent);
    const double square = c * c;
    const double next = sum + square, back = next - sum;
    // What the product and the sum have rounded away.
    rest += std::fma(c, c, -square) + ((sum - (next - back)) + (square - back));
    sum = next;
  }
  return {std::sqrt(sum + rest), exponent};
}

}  // namespace

void RayBatch::reserve(std::size_t count) {
  for (Column<double>* column : {&ox, &oy, &oz, &dx, &dy, &dz, &tmin, &tmax})
    column->reserve(count);
}

void RayBatch::resize(std::size_t count) {
  for (Column<double>* column : {&ox, &oy, &oz, &dx, &dy, &dz, &tmin}) column->resize(count);
  tmax.resize(count, std::numeric_limits<double>::infinity());
}

void RayBatch::push_back(const Ray& ray) {
  ox.push_back(ray.origin.x);
  oy.push_back(ray.origin.y);
  oz.push_back(ray.origin.z);
  dx.push_back(ray.direction.x);
  dy.push_back(ray.direction.y);
  dz.push_back(ray.direction.z);
  tmin.push_back(ray.tmin);
  tmax.push_back(ray.tmax);
}

double distance_of(double t, const Vec3d& direction) {
  const Length length = length_of(direction);
  return std::scalbn(t * length.part, length.exponent);
}

void scale_limits_to_t(RayBatch& rays) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Length length = length_of({rays.dx[i], rays.dy[i], rays.dz[i]});
    for (Column<double>* limit : {&rays.tmin, &rays.tmax})
      (*limit)[i] = std::scalbn((*limit)[i] / length.part, -length.exponent);
  }
}

bool check_rays(const RayBatch& rays, RayFault& fault) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!std::isfinite(rays.ox[i]) || !std::isfinite(rays.oy[i]) || !std::isfinite(rays.oz[i])) {
      fault = {i, "origin", "RAY_NOT_FINITE", "an origin must be three finite numbers"};
      return false;
    }
    if (!std::isfinite(rays.dx[i]) || !std::isfinite(rays.dy[i]) || !std::isfinite(rays.dz[i])) {
      fault = {i, "direction", "RAY_NOT_FINITE", "a direction must be three finite numbers"};
      return false;
    }
    if (rays.dx[i] == 0 && rays.dy[i] == 0 && rays.dz[i] == 0) {
      fault = {i, "direction", "RAY_DIRECTION_ZERO", "a direction must not be zero"};
      return false;
    }
    if (std::isnan(rays.tmin[i])) {
      fault = {i, "tmin", "RAY_LIMIT_NAN", "tmin must be a number"};
      return false;
    }
    if (std::isnan(rays.tmax[i])) {
      fault = {i, "tmax", "RAY_LIMIT_NAN", "tmax must be a number"};
      return false;
    }
    if (rays.tmin[i] > rays.tmax[i]) {
      fault = {i, "tmin", "RAY_LIMITS_REVERSED", "tmin must not be larger than tmax"};
      return false;
    }
  }
  return true;
}

}  // namespace sightline
