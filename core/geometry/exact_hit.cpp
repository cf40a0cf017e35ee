#include "core/geometry/exact_hit.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "core/geometry/dyadic_vector.h"

namespace sightline {

namespace {

DyadicVector normal_of(const Triangle& t) {
  return cross(difference(t.v1, t.v0), difference(t.v2, t.v0));
}

/// An axis along which the plane of n can be projected without losing area; 3 if n is zero.
std::size_t projection_axis(const DyadicVector& n) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (n[k].sign() != 0) return k;
  }
  return 3;
}

/// The points, at most two, where a line in the plane of a triangle meets its border.
struct Crossings {
  std::array<ExactHit, 2> at;
  std::size_t count = 0;
};

Crossings crossings_of(const std::array<DyadicVector, 3>& corner, const DyadicVector& d,
                       const DyadicVector& n) {
  Crossings found;
  // Projects along an axis for which the area is not zero; nor is the direction's component there.
  const std::size_t k = projection_axis(n);
  if (k == 3) return found;
  const std::size_t i = (k + 1) % 3;
  const std::size_t j = (k + 2) % 3;
  const std::size_t m = d[i].sign() != 0 ? i : j;

  // side: on which side of the line each corner lies.
  std::array<Dyadic, 3> side;
  for (std::size_t c = 0; c < 3; ++c) side[c] = d[i] * corner[c][j] - d[j] * corner[c][i];

  // A corner on the line, or an edge whose ends lie strictly on different sides. The corners do not
  // all lie on the line, so there are at most two of these.
  for (std::size_t p = 0; p < 3; ++p) {
    const std::size_t q = (p + 1) % 3;
    if (side[p].sign() == 0) {
      found.at[found.count++].t = ExactT(corner[p][m], d[m]);
    } else if (side[p].sign() * side[q].sign() < 0) {
      found.at[found.count++].t =
          ExactT(side[p] * corner[q][m] - side[q] * corner[p][m], d[m] * (side[p] - side[q]));
    }
  }
  return found;
}

/// crossings_of for a line in the plane of a triangle.
Crossings crossings_of(const FixedHit& hit) {
  std::array<FixedCrossing, 2> at;
  Crossings found;
  found.count = fixed_crossings(hit, at);
  for (std::size_t i = 0; i < found.count; ++i) {
    found.at[i].t = at[i].t;
    found.at[i].edge = at[i].corners;
  }
  return found;
}

/// The line lies in the triangle's plane: the least t of line and closed triangle in [tmin, tmax].
bool coplanar_hit(const Crossings& border, double tmin, double tmax, ExactHit& hit) {
  if (border.count == 0) return false;
  const ExactHit *enter = &border.at[0], *leave = &border.at[border.count - 1];
  if (border.count == 2 && compare(enter->t, leave->t) > 0) std::swap(enter, leave);
  if (compare(enter->t, tmax) > 0 || compare(leave->t, tmin) < 0) return false;
  if (compare(enter->t, tmin) >= 0) {
    hit = *enter;
  } else {
    hit = {ExactT(Dyadic(tmin), Dyadic(1.0)), 0};
  }
  return true;
}

/// True if in some projection along an axis all corners are certainly on one side of the line, so
/// that it misses the triangle.
bool passes_beside(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle) {
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    bool left = true, right = true;
    for (const Vec3d* corner : {&triangle.v0, &triangle.v1, &triangle.v2}) {
      const double a = direction[i] * ((*corner)[j] - origin[j]);
      const double b = direction[j] * ((*corner)[i] - origin[i]);
      // Each product is off by two roundings, their difference by one more. Overflow and NaN make
      // the comparisons false.
      constexpr double kError = 0x1p-50, kUnderflow = 0x1p-1000;
      const double slack = kError * (std::fabs(a) + std::fabs(b)) + kUnderflow;
      left &= a - b > slack;
      right &= a - b < -slack;
    }
    if (left || right) return true;
  }
  return false;
}

}  // namespace

SharedHit shared_hit(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle) {
  return is_finite(triangle) ? fixed_hit(origin, direction, triangle) : std::nullopt;
}

CornerSet corners_at(const Triangle& a, const Triangle& b, CornerSet in_b) {
  const std::array<const Vec3d*, 3> of_a{&a.v0, &a.v1, &a.v2}, of_b{&b.v0, &b.v1, &b.v2};
  CornerSet found = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if ((in_b >> i & 1u) == 0) continue;
    std::size_t j = 0;
    while (j < 3 && !(*of_a[j] == *of_b[i])) ++j;
    if (j == 3) return 0;
    found |= 1u << j;
  }
  return found;
}

Dyadic ExactT::numerator() const {
  const Dyadic numerator = is_fixed_ ? Dyadic(fixed_.numerator, fixed_.exponent) : numerator_;
  const int sign = is_fixed_ ? fixed_.denominator.sign() : denominator_.sign();
  return sign < 0 ? -numerator : numerator;
}

Dyadic ExactT::denominator() const {
  return is_fixed_ ? Dyadic(fixed_.denominator, 0).abs() : denominator_.abs();
}

int ExactT::sign() const {
  return is_fixed_ ? fixed_.numerator.sign() * fixed_.denominator.sign()
                   : numerator_.sign() * denominator_.sign();
}

double ExactT::approximate() const {
  return is_fixed_ ? approximate_quotient(fixed_) : approximate_quotient(numerator_, denominator_);
}

double ExactT::rounded() const {
  if (is_fixed_) {
    if (const auto certain = certain_rounding(fixed_)) return *certain;
  }
  return round_quotient(numerator(), denominator());
}

namespace {

/// The sign of a - b, which ExactT::approximate has approximated; 0 where that does not tell. Each
/// is off by 2^-50 of itself or 2^-1074. Infinities and NaN make the comparisons false.
int certain_order(double a, double b) {
  const double slack = 0x1p-48 * (std::fabs(a) + std::fabs(b)) + 0x1p-1000;
  return a - b > slack ? 1 : b - a > slack ? -1 : 0;
}

// Functions with many Dyadic variables are not inlined. Inside of the frame of one, which has up to
// 300 KB, a caller's few variables and those of the functions that it calls are far apart.

[[gnu::noinline]] int exact_order(const ExactT& a, const ExactT& b) {
  return compare(a.numerator() * b.denominator(), b.numerator() * a.denominator());
}

[[gnu::noinline]] int exact_order(const ExactT& t, double limit) {
  return compare(t.numerator(), Dyadic(limit) * t.denominator());
}

}  // namespace

int compare(const ExactT& a, const ExactT& b) {
  const int order = certain_order(a.approximate(), b.approximate());
  return order != 0 ? order : exact_order(a, b);
}

int compare(const ExactT& t, double limit) {
  if (std::isinf(limit)) return limit > 0 ? -1 : 1;
  if (limit == 0) return t.sign();
  const int order = certain_order(t.approximate(), limit);
  return order != 0 ? order : exact_order(t, limit);
}

bool is_degenerate(const Triangle& triangle) {
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double a = (triangle.v1[i] - triangle.v0[i]) * (triangle.v2[j] - triangle.v0[j]);
    const double b = (triangle.v1[j] - triangle.v0[j]) * (triangle.v2[i] - triangle.v0[i]);
    // Each product is off by three roundings, their difference by one more. Overflow and NaN make
    // the comparison false.
    constexpr double kError = 0x1p-50, kUnderflow = 0x1p-1000;
    if (std::fabs(a - b) > kError * (std::fabs(a) + std::fabs(b)) + kUnderflow) return false;
  }
  return projection_axis(normal_of(triangle)) == 3;
}

bool exact_hit(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
               const Triangle& triangle, ExactT& t) {
  // Brute force asks for triangles far from the line most of the time.
  if (passes_beside(origin, direction, triangle)) return false;
  ExactHit hit;
  const bool met = exact_hit(origin, direction, tmin, tmax, triangle,
                             shared_hit(origin, direction, triangle), hit);
  if (met) t = hit.t;
  return met;
}

namespace {

/// exact_hit for a line in the plane, or a triangle without area.
[[gnu::noinline]] bool in_plane_hit(const FixedHit& fixed, double tmin, double tmax,
                                    ExactHit& hit) {
  return coplanar_hit(crossings_of(fixed), tmin, tmax, hit);
}

/// exact_hit by wide numbers. It leaves the edge unknown.
[[gnu::noinline]] bool wide_hit(const Vec3d& origin, const Vec3d& direction, double tmin,
                                double tmax, const Triangle& triangle, ExactHit& hit) {
  if (passes_beside(origin, direction, triangle)) return false;
  const std::array<DyadicVector, 3> corner{difference(triangle.v0, origin),
                                           difference(triangle.v1, origin),
                                           difference(triangle.v2, origin)};
  const DyadicVector d = exact_vector(direction);

  // A miss is two signs that disagree; leave as soon as they do.
  const DyadicVector bc = cross(corner[1], corner[2]);
  const Dyadic w0 = dot(d, bc);
  const DyadicVector ca = cross(corner[2], corner[0]);
  const Dyadic w1 = dot(d, ca);
  if (w0.sign() * w1.sign() < 0) return false;
  const DyadicVector ab = cross(corner[0], corner[1]);
  const Dyadic w2 = dot(d, ab);
  if (w0.sign() * w2.sign() < 0 || w1.sign() * w2.sign() < 0) return false;

  const Dyadic determinant = w0 + w1 + w2;
  if (determinant.sign() == 0) {
    return coplanar_hit(crossings_of(corner, d, normal_of(triangle)), tmin, tmax, hit);
  }
  hit = {ExactT(dot(corner[0], bc), determinant), 0};
  return compare(hit.t, tmin) >= 0 && compare(hit.t, tmax) <= 0;
}

}  // namespace

bool exact_hit(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
               const Triangle& triangle, const SharedHit& shared, ExactHit& hit) {
  if (!is_finite(triangle)) return false;
  if (!shared) return wide_hit(origin, direction, tmin, tmax, triangle, hit);
  const std::array<int, 3> sign{shared->w0.sign(), shared->w1.sign(), shared->w2.sign()};
  if (sign[0] * sign[1] < 0 || sign[0] * sign[2] < 0 || sign[1] * sign[2] < 0) return false;
  if ((sign[0] | sign[1] | sign[2]) == 0) return in_plane_hit(*shared, tmin, tmax, hit);
  hit.edge = 0;
  for (std::size_t i = 0; i < 3; ++i) hit.edge |= sign[i] != 0 ? 1u << i : 0u;
  if (hit.edge == 7) hit.edge = 0;  // in the interior
  hit.t = FixedT{shared->numerator, shared->w0 + shared->w1 + shared->w2,
                 shared->space_exponent - shared->direction_exponent};
  return compare(hit.t, tmin) >= 0 && compare(hit.t, tmax) <= 0;
}

namespace {

/// Side of the moved line on which the edge from p to q passes; p and q are seen from the origin.
/// Zero only for edges parallel to the line.
int moved_side(const DyadicVector& d, const DyadicVector& p, const DyadicVector& q) {
  // d.((p - m) x (q - m)) = d.(p x q) + m.((p - q) x d): linear in the movement m.
  const int side = dot(d, cross(p, q)).sign();
  if (side != 0) return side;
  const DyadicVector edge{p[0] - q[0], p[1] - q[1], p[2] - q[2]};
  for (std::size_t k = 0; k < 3; ++k) {
    const int moved = cross_component(edge, d, k).sign();
    if (moved != 0) return moved;
  }
  return 0;
}

Vec3d rounded_unit(const DyadicVector& n) {
  const Dyadic square = dot(n, n);
  return {round_over_root(n[0], square), round_over_root(n[1], square),
          round_over_root(n[2], square)};
}

}  // namespace

bool exact_crossing(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle) {
  if (!is_finite(triangle)) return false;
  const DyadicVector d = exact_vector(direction);
  if (dot(d, normal_of(triangle)).sign() == 0) return false;
  const DyadicVector a = difference(triangle.v0, origin);
  const DyadicVector b = difference(triangle.v1, origin);
  const DyadicVector c = difference(triangle.v2, origin);
  const int side = moved_side(d, a, b);
  return side == moved_side(d, b, c) && side == moved_side(d, c, a);
}

int certain_side_sign(const Vec3d& direction, const Triangle& triangle) {
  double e1[3], e2[3], sum = 0, size = 0, largest = 0;
  for (int k = 0; k < 3; ++k) {
    e1[k] = triangle.v1[k] - triangle.v0[k];
    e2[k] = triangle.v2[k] - triangle.v0[k];
    largest = std::fmax(largest, std::fabs(direction[k]));
  }
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double a = e1[i] * e2[j], b = e1[j] * e2[i];
    sum += direction[k] * (a - b);
    size += std::fabs(direction[k]) * (std::fabs(a) + std::fabs(b));
  }
  // No term passes more than eight roundings of 2^-53 (differences, products, sums); what underflow
  // takes from a product is below 2^-1074 and is multiplied by at most 2^100. Overflow makes the
  // comparison false.
  constexpr double kError = 0x1p-49, kUnderflow = 0x1p-960, kLargest = 0x1p100;
  if (!(largest < kLargest && std::fabs(sum) > size * kError + kUnderflow)) return 0;
  return sum < 0 ? -1 : 1;
}

int side_sign(const Vec3d& direction, const Triangle& triangle) {
  if (const int sign = certain_side_sign(direction, triangle); sign != 0) return sign;
  const DyadicVector d = exact_vector(direction);
  return dot(d, normal_of(triangle)).sign();
}

bool is_on_edge(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle,
                const ExactT& t) {
  // In a projection in which the area is not zero: the sides of the point to the three edges, one
  // of which is zero on the border. The point is t * d as seen from the origin, here multiplied by
  // t's denominator, so that rays inside the plane need no case of their own.
  const std::size_t k = projection_axis(normal_of(triangle));
  const DyadicVector d = exact_vector(direction);
  const Dyadic numerator = t.numerator(), denominator = t.denominator();
  const std::array<const Vec3d*, 3> corner{&triangle.v0, &triangle.v1, &triangle.v2};
  for (std::size_t c = 0; c < 3; ++c) {
    const DyadicVector a = difference(*corner[c], origin);
    const DyadicVector edge = difference(*corner[(c + 1) % 3], *corner[c]);
    DyadicVector p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = numerator * d[i] - denominator * a[i];
    if (cross_component(edge, p, k).sign() == 0) return true;
  }
  return false;
}

Vec3d exact_normal(const Triangle& triangle) { return rounded_unit(normal_of(triangle)); }

ExactDetail exact_detail(const Vec3d& origin, const Vec3d& direction, const Triangle& triangle,
                         const ExactT& t) {
  ExactDetail detail;
  const Dyadic numerator = t.numerator(), denominator = t.denominator();
  const auto coordinate = [&](double o, double d) {
    return round_quotient(Dyadic(o) * denominator + numerator * Dyadic(d), denominator);
  };
  detail.position = {coordinate(origin.x, direction.x), coordinate(origin.y, direction.y),
                     coordinate(origin.z, direction.z)};

  const DyadicVector n = normal_of(triangle);
  detail.normal = rounded_unit(n);
  const DyadicVector d = exact_vector(direction);
  detail.front = dot(d, n).sign() < 0;

  // Barycentrics as ratios of areas in a projection in which the area is not zero; the point is t *
  // d as seen from the origin, here multiplied by t's denominator.
  const std::size_t k = projection_axis(n);
  const DyadicVector a = difference(triangle.v0, origin);
  const DyadicVector e1 = difference(triangle.v1, triangle.v0);
  const DyadicVector e2 = difference(triangle.v2, triangle.v0);
  DyadicVector p;
  for (std::size_t c = 0; c < 3; ++c) p[c] = numerator * d[c] - denominator * a[c];
  const Dyadic area = denominator * n[k];
  detail.u = round_quotient(cross_component(p, e2, k), area);
  detail.v = round_quotient(cross_component(e1, p, k), area);
  return detail;
}

}  // namespace sightline
