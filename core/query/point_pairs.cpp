#include "core/query/point_pairs.h"

#include <cmath>
#include <limits>

#include "core/base/infinity.h"
#include "core/geometry/triangle.h"
#include "core/query/vector_arithmetic.h"

namespace sightline {

namespace {

PairFault ends_of(const PointPairs& pairs, std::size_t i) {
  if (pairs.pairing == BoxPairing::kEach) return {i, i};
  return {i / pairs.to.size(), i % pairs.to.size()};
}

}  // namespace

Ray PointPairs::ray(std::size_t i) const {
  const PairFault ends = ends_of(*this, i);
  Ray ray;
  ray.origin = from[ends.from];
  ray.direction = minus(to[ends.to], ray.origin);
  if (to[ends.to] == ray.origin) {
    ray.direction = {1, 0, 0};
    ray.tmin = ray.tmax = closed ? 0 : kInf;
  } else if (closed) {
    ray.tmax = 1;
  } else {
    ray.tmin = std::numeric_limits<double>::denorm_min();
    ray.tmax = std::nextafter(1.0, 0.0);
  }
  return ray;
}

bool check_pairs(const PointPairs& pairs, PairFault& fault) {
  // Extremes first: almost always no pair has to be checked.
  Vec3d low{kInf, kInf, kInf}, high{-kInf, -kInf, -kInf};
  for (const auto* points : {&pairs.from, &pairs.to}) {
    for (const Vec3d& p : *points) {
      for (int k = 0; k < 3; ++k) {
        low[k] = std::fmin(low[k], p[k]);
        high[k] = std::fmax(high[k], p[k]);
      }
    }
  }
  if (pairs.size() == 0 || is_finite(minus(high, low))) return true;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    fault = ends_of(pairs, i);
    if (!is_finite(minus(pairs.to[fault.to], pairs.from[fault.from]))) return false;
  }
  return true;
}

}  // namespace sightline
