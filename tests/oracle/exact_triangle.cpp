#include "tests/oracle/exact_triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace sightline::oracle {
namespace {

using Integers = std::array<mpz_class, 3>;
using Rationals = std::array<mpq_class, 3>;

Integers operator-(const Integers& a, const Integers& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Integers cross(const Integers& a, const Integers& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
mpz_class dot(const Integers& a, const Integers& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
bool is_zero(const Integers& a) { return sgn(a[0]) == 0 && sgn(a[1]) == 0 && sgn(a[2]) == 0; }

/// Points as integers in units of 2^exponent, the largest unit that makes all of them whole.
template <std::size_t kCount>
struct Whole {
  std::array<Integers, kCount> points;
  int exponent = 0;

  explicit Whole(const std::array<Vec3d, kCount>& values) {
    std::array<Binary, 3 * kCount> parts;
    int least = std::numeric_limits<int>::max();
    for (std::size_t i = 0; i < 3 * kCount; ++i) {
      parts[i] = split(values[i / 3][static_cast<int>(i % 3)]);
      if (parts[i].mantissa != 0) least = std::min(least, parts[i].exponent);
    }
    if (least == std::numeric_limits<int>::max()) least = 0;
    exponent = least;
    for (std::size_t i = 0; i < 3 * kCount; ++i) {
      mpz_class& whole = points[i / 3][i % 3];
      whole = static_cast<long>(parts[i].mantissa);
      if (parts[i].mantissa != 0) whole <<= static_cast<mp_bitcnt_t>(parts[i].exponent - least);
    }
  }
};

/// The ray lies in the plane of the triangle: clips the line against the three edges, seen along an
/// axis in which the normal is not zero.
std::optional<Rational> least_t_in_plane(const Ray& ray, const Integers& origin,
                                         const Integers& direction, std::span<const Integers, 3> v,
                                         const Integers& normal, long shift) {
  const std::size_t drop = sgn(normal[0]) != 0 ? 0 : sgn(normal[1]) != 0 ? 1 : 2;
  const std::size_t x = (drop + 1) % 3;
  const std::size_t y = (drop + 2) % 3;
  const bool flip = sgn(normal[drop]) < 0;

  std::optional<Rational> enter;
  std::optional<Rational> leave;
  for (std::size_t i = 0; i < 3; ++i) {
    // f(t) = edge x (origin + t * direction - v) is a + b t, and not negative inside.
    const Integers edge = v[(i + 1) % 3] - v[i];
    const Integers to_origin = origin - v[i];
    mpz_class a = edge[x] * to_origin[y] - edge[y] * to_origin[x];
    mpz_class b = edge[x] * direction[y] - edge[y] * direction[x];
    if (flip) {
      a = -a;
      b = -b;
    }
    if (sgn(b) == 0) {
      if (sgn(a) < 0) return std::nullopt;
    } else if (sgn(b) > 0) {
      Rational bound{-a, b, shift};
      if (!enter || compare(bound, *enter) > 0) enter = bound;
    } else {
      Rational bound{a, -b, shift};
      if (!leave || compare(bound, *leave) < 0) leave = bound;
    }
  }
  // A direction that is not zero in the plane crosses a bounded set: both ends exist.
  if (!enter || !leave || compare(*enter, *leave) > 0) return std::nullopt;
  if (compare(*leave, ray.tmin) < 0 || compare(*enter, ray.tmax) > 0) return std::nullopt;
  if (compare(*enter, ray.tmin) >= 0) return enter;
  return exact(ray.tmin);
}

mpq_class dot(const Rationals& a, const Rationals& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Rationals cross(const Rationals& a, const Rationals& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Rationals difference(const Rationals& a, const Rationals& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Rationals rationals(const Vec3d& v) { return {mpq_class(v.x), mpq_class(v.y), mpq_class(v.z)}; }

}  // namespace

bool is_finite(const Triangle& triangle) {
  for (const Vec3d& v : {triangle.v0, triangle.v1, triangle.v2}) {
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) return false;
  }
  return true;
}

bool has_no_area(const Triangle& triangle) {
  const Whole<3> w({triangle.v0, triangle.v1, triangle.v2});
  return is_zero(cross(w.points[1] - w.points[0], w.points[2] - w.points[0]));
}

std::optional<Rational> least_t(const Ray& ray, const Triangle& triangle) {
  const Whole<4> w({ray.origin, triangle.v0, triangle.v1, triangle.v2});
  const Whole<1> line({ray.direction});
  const Integers& origin = w.points[0];
  const Integers& direction = line.points[0];
  const std::span<const Integers, 3> v(&w.points[1], 3);
  const long shift = w.exponent - line.exponent;

  const Integers e1 = v[1] - v[0];
  const Integers e2 = v[2] - v[0];
  const Integers normal = cross(e1, e2);
  if (is_zero(normal)) return std::nullopt;

  const Integers s = v[0] - origin;
  mpz_class det = dot(direction, normal);
  mpz_class t = dot(s, normal);
  if (sgn(det) == 0) {
    if (sgn(t) != 0) return std::nullopt;
    return least_t_in_plane(ray, origin, direction, v, normal, shift);
  }

  // Cramer's rule on t d - u e1 - v e2 = v0 - o.
  mpz_class u_weight = dot(direction, cross(e2, s));
  mpz_class v_weight = dot(direction, cross(s, e1));
  if (sgn(det) < 0) {
    det = -det;
    t = -t;
    u_weight = -u_weight;
    v_weight = -v_weight;
  }
  if (sgn(u_weight) < 0 || sgn(v_weight) < 0 || u_weight + v_weight > det) return std::nullopt;

  Rational result{t, det, shift};
  if (compare(result, ray.tmin) < 0 || compare(result, ray.tmax) > 0) return std::nullopt;
  return result;
}

bool crosses_when_moved(const Ray& ray, const Triangle& triangle) {
  const Whole<4> w({ray.origin, triangle.v0, triangle.v1, triangle.v2});
  const Whole<1> line({ray.direction});
  const Integers& direction = line.points[0];
  const std::span<const Integers, 3> v(&w.points[1], 3);

  // The moved line passes the edge from p to q on the side that the sign of
  // d . ((p - o - m) x (q - o - m)) says, which is a polynomial in e with the coefficients below;
  // for small e the first one that is not zero decides.
  int side = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Integers p = v[i] - w.points[0];
    const Integers q = v[(i + 1) % 3] - w.points[0];
    const Integers slope = cross(p - q, direction);
    int sign = sgn(dot(direction, cross(p, q)));
    for (std::size_t k = 0; k < 3 && sign == 0; ++k) sign = sgn(slope[k]);
    if (sign == 0 || (i > 0 && sign != side)) return false;
    side = sign;
  }
  return true;
}

ExactDetail exact_detail(const Ray& ray, const Triangle& triangle, const Rational& t) {
  const mpq_class t_exact = to_mpq(t);
  const Rationals origin = rationals(ray.origin);
  const Rationals direction = rationals(ray.direction);
  const Rationals v0 = rationals(triangle.v0);
  const Rationals e1 = difference(rationals(triangle.v1), v0);
  const Rationals e2 = difference(rationals(triangle.v2), v0);

  ExactDetail detail;
  for (std::size_t k = 0; k < 3; ++k) detail.position[k] = origin[k] + t_exact * direction[k];
  detail.normal = cross(e1, e2);
  // p - v0 = u e1 + v e2; both weights by areas along the normal.
  const Rationals p = difference(detail.position, v0);
  const mpq_class area = dot(detail.normal, detail.normal);
  detail.u = dot(cross(p, e2), detail.normal) / area;
  detail.v = dot(cross(e1, p), detail.normal) / area;
  detail.front = sgn(dot(direction, detail.normal)) < 0;
  return detail;
}

}  // namespace sightline::oracle
