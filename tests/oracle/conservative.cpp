#include "tests/oracle/conservative.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace sightline::oracle {
namespace {

/// A sum of products with a bound of its error.
struct Estimate {
  long double value = 0;
  long double error = 0;
};

struct Wide {
  long double x, y, z;
};

Wide difference(const Vec3d& a, const Vec3d& b) {
  using L = long double;
  return {L{a.x} - L{b.x}, L{a.y} - L{b.y}, L{a.z} - L{b.z}};
}

/// 16 u with u = 2^-64. A term below has at most 7 roundings (a difference in each of two factors,
/// two products, three sums), so its error is at most ((1+u)^7 - 1) times its magnitude; the
/// computed sum of the magnitudes is at least (1-u)^7 times the exact one. 7.1 u would do.
constexpr long double kError = 16 * 0x1p-64L;

/// a . (b x c)
Estimate triple(const Wide& a, const Wide& b, const Wide& c) {
  const long double yz = b.y * c.z, zy = b.z * c.y;
  const long double zx = b.z * c.x, xz = b.x * c.z;
  const long double xy = b.x * c.y, yx = b.y * c.x;
  Estimate result;
  result.value = a.x * (yz - zy) + a.y * (zx - xz) + a.z * (xy - yx);
  result.error = kError * (std::fabs(a.x) * (std::fabs(yz) + std::fabs(zy)) +
                           std::fabs(a.y) * (std::fabs(zx) + std::fabs(xz)) +
                           std::fabs(a.z) * (std::fabs(xy) + std::fabs(yx)));
  return result;
}

int certain_sign(const Estimate& estimate) {
  if (estimate.value > estimate.error) return 1;
  if (estimate.value < -estimate.error) return -1;
  return 0;
}

}  // namespace

double next_up(double value) {
  if (value == std::numeric_limits<double>::infinity()) return value;
  if (value == 0) return std::numeric_limits<double>::denorm_min();
  const auto bits = std::bit_cast<std::uint64_t>(value);
  return std::bit_cast<double>(value > 0 ? bits + 1 : bits - 1);
}
double next_down(double value) { return -next_up(-value); }

Overlap overlap(const Ray& ray, const Bounds& bounds, double tmax) {
  Overlap result{ray.tmin, tmax};
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis];
    const double d = ray.direction[axis];
    const double low = bounds.min[axis];
    const double high = bounds.max[axis];
    if (d == 0) {
      if (o < low || o > high) return {1, 0};
      continue;
    }
    double from = next_down(low - o) / d;
    double to = next_up(high - o) / d;
    if (d < 0) std::swap(from, to);
    result.low = std::max(result.low, next_down(from));
    result.high = std::min(result.high, next_up(to));
  }
  return result;
}

bool may_meet(const Ray& ray, const Triangle& triangle, double tmax) {
  const Wide d{ray.direction.x, ray.direction.y, ray.direction.z};
  const Wide s0 = difference(triangle.v0, ray.origin);
  const Wide s1 = difference(triangle.v1, ray.origin);
  const Wide s2 = difference(triangle.v2, ray.origin);

  // The line passes the three edges on the same side, or touches them. (In the triangle's plane all
  // three are exactly zero; parallel to it they are of both signs or zero, and it is a miss.)
  const int side0 = certain_sign(triple(d, s1, s2));
  const int side1 = certain_sign(triple(d, s2, s0));
  const int side2 = certain_sign(triple(d, s0, s1));
  if (std::min({side0, side1, side2}) < 0 && std::max({side0, side1, side2}) > 0) return false;

  // The interval of t, where the plane is crossed for certain.
  const Wide e1 = difference(triangle.v1, triangle.v0);
  const Wide e2 = difference(triangle.v2, triangle.v0);
  const Estimate det = triple(d, e1, e2);
  if (certain_sign(det) == 0) return true;
  const Estimate t = triple(s0, e1, e2);
  const long double ends[] = {
      (t.value - t.error) / (det.value - det.error), (t.value - t.error) / (det.value + det.error),
      (t.value + t.error) / (det.value - det.error), (t.value + t.error) / (det.value + det.error)};
  const auto [least, most] = std::minmax_element(std::begin(ends), std::end(ends));
  // Three roundings each: numerator, denominator, quotient.
  const long double low = *least - kError * std::fabs(*least);
  const long double high = *most + kError * std::fabs(*most);
  return !(high < static_cast<long double>(ray.tmin) || low > static_cast<long double>(tmax));
}

bool certainly_has_area(const Triangle& triangle) {
  const Wide e1 = difference(triangle.v1, triangle.v0);
  const Wide e2 = difference(triangle.v2, triangle.v0);
  const Wide axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  return std::any_of(std::begin(axes), std::end(axes),
                     [&](const Wide& axis) { return certain_sign(triple(axis, e1, e2)) != 0; });
}

}  // namespace sightline::oracle
