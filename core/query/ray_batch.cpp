#include "core/query/ray_batch.h"

#include <bit>
#include <cmath>
#include <limits>

#include "core/base/infinity.h"
#include "core/geometry/triangle.h"

namespace sightline {

namespace {

/// part * 2^exponent: beyond the range of float64 too.
struct Length {
  double part = 1;
  int exponent = 0;
};

/// Within one unit in the last place, with 1 <= part < 4.
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

/// x as part * 2^exponent, with 1/2 <= |part| < 1; zero, infinities and NaN with the exponent 0.
Length parts_of(double x) {
  Length parts{x, 0};
  if (std::isfinite(x)) parts.part = std::frexp(x, &parts.exponent);
  return parts;
}

}  // namespace

void RayBatch::reserve(std::size_t count) {
  for (UnsetColumn<double>* column : {&ox, &oy, &oz, &dx, &dy, &dz, &tmin, &tmax})
    column->reserve(count);
}

void RayBatch::resize(std::size_t count) {
  for (UnsetColumn<double>* column : {&ox, &oy, &oz, &dx, &dy, &dz}) column->resize(count);
  tmin.resize(count, 0);
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
  // A subnormal t has too few bits to be multiplied, a large one overflows: its part does neither.
  const Length length = length_of(direction), parts = parts_of(t);
  return std::scalbn(parts.part * length.part, parts.exponent + length.exponent);
}

void scale_limits_to_t(RayBatch& rays) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Length length = length_of({rays.dx[i], rays.dy[i], rays.dz[i]});
    for (UnsetColumn<double>* limit : {&rays.tmin, &rays.tmax}) {
      const Length parts = parts_of((*limit)[i]);
      (*limit)[i] = std::scalbn(parts.part / length.part, parts.exponent - length.exponent);
    }
  }
}

namespace {

/// What is wrong with one ray, without its number. An empty code: nothing.
RayFault fault_of(const Ray& ray) {
  if (!is_finite(ray.origin)) {
    return {0, "origin", "RAY_NOT_FINITE", "an origin must be three finite numbers"};
  }
  if (!is_finite(ray.direction)) {
    return {0, "direction", "RAY_NOT_FINITE", "a direction must be three finite numbers"};
  }
  if (ray.direction.x == 0 && ray.direction.y == 0 && ray.direction.z == 0) {
    return {0, "direction", "RAY_DIRECTION_ZERO", "a direction must not be zero"};
  }
  if (std::isnan(ray.tmin)) return {0, "tmin", "RAY_LIMIT_NAN", "tmin must be a number"};
  if (std::isnan(ray.tmax)) return {0, "tmax", "RAY_LIMIT_NAN", "tmax must be a number"};
  if (ray.tmin > ray.tmax) {
    return {0, "tmin", "RAY_LIMITS_REVERSED", "tmin must not be larger than tmax"};
  }
  return {};
}

constexpr std::size_t kTogether = 256;

/// True if fault_of would find nothing in so many rays, without a branch for each. Compilers check
/// several rays of the six columns at once.
bool all_good(const RayBatch& rays, std::size_t begin) {
  const double *const ox = rays.ox.data() + begin, *const oy = rays.oy.data() + begin,
                      *const oz = rays.oz.data() + begin, *const dx = rays.dx.data() + begin,
                      *const dy = rays.dy.data() + begin, *const dz = rays.dz.data() + begin,
                      *const tmin = rays.tmin.data() + begin,
                      *const tmax = rays.tmax.data() + begin;
  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
  // Of finite numbers each difference is 0, whose bits are zeros too; of others it is NaN.
  std::uint64_t not_finite = 0, not_zero = 1;
  for (std::size_t i = 0; i < kTogether; ++i) {
    not_finite |= bits(ox[i] - ox[i]) | bits(oy[i] - oy[i]) | bits(oz[i] - oz[i]) |
                  bits(dx[i] - dx[i]) | bits(dy[i] - dy[i]) | bits(dz[i] - dz[i]);
    // Without the sign; what is not zero has its highest bit set, or its complement has.
    const std::uint64_t any = (bits(dx[i]) | bits(dy[i]) | bits(dz[i])) << 1;
    not_zero &= (any | (0 - any)) >> 63;
  }
  bool ordered = true;
  for (std::size_t i = 0; i < kTogether; ++i) ordered = ordered & (tmin[i] <= tmax[i]);
  return not_finite == 0 && not_zero == 1 && ordered;
}

}  // namespace

bool check_rays(const RayBatch& rays, RayFault& fault) {
  std::size_t begin = 0;
  while (begin + kTogether <= rays.size() && all_good(rays, begin)) begin += kTogether;
  for (std::size_t i = begin; i < rays.size(); ++i) {
    RayFault found = fault_of(rays[i]);
    if (*found.code == '\0') continue;
    found.ray = i;
    fault = found;
    return false;
  }
  return true;
}

InvalidRays replace_invalid(RayBatch& rays) {
  // No real t is infinite.
  InvalidRays invalid;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const RayFault found = fault_of(rays[i]);
    if (*found.code == '\0') continue;
    invalid.number.push_back(i);
    invalid.code.push_back(found.code);
    rays.ox[i] = rays.oy[i] = rays.oz[i] = rays.dy[i] = rays.dz[i] = 0;
    rays.dx[i] = 1;
    rays.tmin[i] = rays.tmax[i] = kInf;
  }
  return invalid;
}

}  // namespace sightline
