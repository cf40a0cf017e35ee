#include "core/trace/search/solid_angle.h"

#include <array>
#include <cmath>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/float64_vector.h"

namespace sightline {

namespace {

using float64::Numbers;

constexpr double kPi = 3.14159265358979323846;

/// atan of x in [0, 1], within 2^-50: two halvings of the angle leave at most tan(pi / 16), for which
/// twelve terms of the series are enough.
double arc_tangent(double x) {
  for (int i = 0; i < 2; ++i) x = x / (1 + std::sqrt(1 + x * x));
  const double square = x * x;
  double sum = 0;
  for (int k = 11; k >= 0; --k) sum = 1.0 / (2 * k + 1) - square * sum;
  return 4 * (x * sum);
}

/// The angle of (x, y) with the x axis, in [-pi, pi]; the sign is that of `sign`.
double angle_of(double y, double x, int sign) {
  const double up = std::fabs(y), along = std::fabs(x);
  if (up == 0 && along == 0) return 0;
  double angle = up <= along ? arc_tangent(up / along) : kPi / 2 - arc_tangent(along / up);
  if (x < 0) angle = kPi - angle;
  return sign < 0 ? -angle : angle;
}

/// v - p, times a power of two that brings the largest component into [1, 2). Each component is
/// within 2^-53 of itself.
Numbers direction_to(const Vec3d& v, const Vec3d& p) {
  Numbers d = float64::minus(v, p);
  const double size = float64::largest(d);
  if (!(size > 0) || !std::isfinite(size)) return d;
  const int exponent = -std::ilogb(size);
  for (double& x : d) x = std::ldexp(x, exponent);
  return d;
}

/// The sign of (a - p) . ((b - p) x c) for a p that is displaced by (e, e^2, e^3).
int displaced_sign(const OpenEdge& edge, const Vec3d& p, const Vec3d& c) {
  const DyadicVector exact = exact_vector(c);
  const int sign = dot(difference(edge.from, p), cross(difference(edge.to, p), exact)).sign();
  if (sign != 0) return sign;
  const DyadicVector moved = cross(difference(edge.from, edge.to), exact);
  for (const Dyadic& component : moved)
    if (component.sign() != 0) return component.sign();
  return 0;
}

}  // namespace

BoundedNumber winding_of_open_edges(const std::vector<OpenEdge>& edges, const Vec3d& p,
                                    const Vec3d& u) {
  using float64::cross, float64::dot;
  const Vec3d infinity{-u.x, -u.y, -u.z};
  const Numbers c{infinity.x, infinity.y, infinity.z};
  const double c_length = std::sqrt(dot(c, c));
  // Numbers below are within some units of 2^-53 times the product of the three lengths.
  constexpr double kDoubt = 0x1p-46, kSlack = 0x1p-46, kRounding = 0x1p-51;
  BoundedNumber sum;
  double lost = 0;
  for (const OpenEdge& edge : edges) {
    if (!is_finite(edge.from) || !is_finite(edge.to)) continue;
    const Numbers a = direction_to(edge.from, p), b = direction_to(edge.to, p);
    const double a_length = std::sqrt(dot(a, a)), b_length = std::sqrt(dot(b, b));
    const double size = a_length * b_length * c_length;
    const double determinant = dot(a, cross(b, c));
    const double along = size + dot(a, b) * c_length + dot(a, c) * b_length + dot(b, c) * a_length;
    int sign = determinant < 0 ? -1 : 1;
    if (std::fabs(determinant) <= kDoubt * size) {
      sign = displaced_sign(edge, p, infinity);
      // The edge is parallel to the ray, which passes it by.
      if (sign == 0) continue;
    }
    const double length = std::sqrt(determinant * determinant + along * along);
    const double times = std::fabs(edge.times);
    const double error = kSlack * size / length + kRounding;
    // NaN and infinity are as wrong as can be.
    if (!(error < 1)) {
      sum.error += times;
      continue;
    }
    const double term = edge.times * (angle_of(determinant, along, sign) / (2 * kPi));
    sum.error += times * error;
    // Compensated summation [Neumaier1974].
    const double next = sum.value + term;
    lost += std::fabs(sum.value) >= std::fabs(term) ? (sum.value - next) + term
                                                    : (term - next) + sum.value;
    sum.value = next;
  }
  sum.value += lost;
  sum.error += kRounding * std::fabs(sum.value);
  return sum;
}

}  // namespace sightline
