#include "core/geometry/sphere_sweep.h"

#include <array>
#include <cmath>

#include "core/geometry/exact_hit.h"
#include "core/geometry/point_triangle.h"

namespace sightline {

namespace {

using Quadratic = SphereContact::Quadratic;
using OfPlane = SphereContact::OfPlane;

Dyadic discriminant(const Quadratic& q) { return q.b * q.b - q.a * q.c; }

/// origin + t * direction, exactly.
DyadicVector center_at(const SweepPath& path, double t) {
  DyadicVector at = exact_vector(path.origin);
  for (int k = 0; k < 3; ++k) {
    Dyadic& x = at[static_cast<std::size_t>(k)];
    x = x + Dyadic(t) * Dyadic(path.direction[k]);
  }
  return at;
}

/// Sign of the lesser root of a quadratic minus a number at which the quadratic has the sign
/// `value` and its derivative the sign `slope`.
int root_minus(int value, int slope) {
  if (value < 0) return -1;
  if (value == 0) return slope <= 0 ? 0 : -1;
  return slope < 0 ? 1 : -1;
}

/// Sign of the root minus numerator / divisor.
int compare_root(const Quadratic& q, const Dyadic& numerator, const Dyadic& divisor) {
  const Dyadic linear = q.a * numerator + q.b * divisor;
  const Dyadic value = numerator * (linear + q.b * divisor) + q.c * divisor * divisor;
  return root_minus(value.sign(), linear.sign());
}
int compare_root(const OfPlane& t, const Dyadic& numerator, const Dyadic& divisor) {
  return sign_with_root(t.p * divisor - numerator * t.rate, -(t.radius * divisor), t.square);
}

/// Sign of the root of x minus that of y: the sign of y's quadratic at the root of x is that of a
/// linear function there, L = a_x y - a_y x.
int compare_roots(const Quadratic& x, const Quadratic& y) {
  const Dyadic half = x.a * y.b - y.a * x.b;
  const Dyadic constant = x.a * y.c - y.a * x.c;
  int value = constant.sign();
  if (half.sign() != 0) {
    // L = 2 half t + constant changes its sign at -constant / (2 half).
    const Dyadic twice = half + half;
    const int side =
        half.sign() > 0 ? compare_root(x, -constant, twice) : -compare_root(x, constant, -twice);
    value = side;
  }
  // y's derivative at the root of x, times a_x: half - a_y sqrt(discriminant of x).
  const int slope = sign_with_root(half, -y.a, discriminant(x));
  return -root_minus(value, slope);
}

int compare_roots(const OfPlane& x, const Quadratic& y) {
  // y at x times rate^2, and its derivative times rate: both of the form X + Y sqrt(square).
  const Dyadic squares = x.p * x.p + x.radius * x.radius * x.square;
  const Dyadic value = y.a * squares + (y.b * x.p + y.b * x.p) * x.rate + y.c * x.rate * x.rate;
  const Dyadic product = y.a * x.p + y.b * x.rate;
  const int of_value = sign_with_root(value, -((product + product) * x.radius), x.square);
  const int slope = sign_with_root(product, -(y.a * x.radius), x.square);
  return -root_minus(of_value, slope);
}

int compare_roots(const OfPlane& x, const OfPlane& y) {
  // a - radius (rate_y sqrt(square_x) - rate_x sqrt(square_y)), times something positive.
  const Dyadic a = x.p * y.rate - y.p * x.rate;
  const Dyadic of_x = y.rate * y.rate * x.square, of_y = x.rate * x.rate * y.square;
  const int of_roots = x.radius.sign() == 0 ? 0 : -compare(of_x, of_y);
  if (of_roots == 0 || a.sign() == of_roots) return a.sign();
  if (a.sign() == 0) return of_roots;
  // a^2 against radius^2 (of_x + of_y - 2 sqrt(of_x of_y)).
  const Dyadic square = x.radius * x.radius;
  return a.sign() * sign_with_root(a * a - square * (of_x + of_y), square + square, of_x * of_y);
}

/// What the way looks like from a triangle.
struct Seen {
  DyadicVector direction;
  std::array<DyadicVector, 3> from;  ///< origin minus corner
  std::array<DyadicVector, 3> edge;  ///< from corner i to the next
  Dyadic square;                     ///< of the radius

  Seen(const SweepPath& path, const SweptSphere& sphere, const Triangle& t)
      : direction(exact_vector(path.direction)),
        from{difference(path.origin, t.v0), difference(path.origin, t.v1),
             difference(path.origin, t.v2)},
        edge{difference(t.v1, t.v0), difference(t.v2, t.v1), difference(t.v0, t.v2)},
        square(Dyadic(sphere.radius) * Dyadic(sphere.radius)) {}

  std::optional<Quadratic> to_corner(std::size_t i) const {
    const Quadratic q{dot(direction, direction), dot(from[i], direction),
                      dot(from[i], from[i]) - square};
    return discriminant(q).sign() < 0 ? std::nullopt : std::optional(q);
  }

  /// If it comes to the edge's line between the edge's ends.
  std::optional<Quadratic> to_edge(std::size_t i) const {
    const DyadicVector& e = edge[i];
    const DyadicVector across = cross(direction, e), beside = cross(from[i], e);
    const Dyadic length = dot(e, e);
    const Quadratic q{dot(across, across), dot(beside, across),
                      dot(beside, beside) - square * length};
    if (q.a.sign() == 0 || discriminant(q).sign() < 0) return std::nullopt;
    // The foot is at (begin + t step) / length of the edge.
    const Dyadic begin = dot(from[i], e), step = dot(direction, e);
    const auto is_above = [&](const Dyadic& value) {  // value + t step >= 0
      if (step.sign() == 0) return value.sign() >= 0;
      return step.sign() > 0 ? compare_root(q, -value, step) >= 0
                             : compare_root(q, value, -step) <= 0;
    };
    const auto is_below = [&](const Dyadic& value) {  // value + t step <= 0
      if (step.sign() == 0) return value.sign() <= 0;
      return step.sign() > 0 ? compare_root(q, -value, step) <= 0
                             : compare_root(q, value, -step) >= 0;
    };
    return is_above(begin) && is_below(begin - length) ? std::optional(q) : std::nullopt;
  }

  /// If it comes to the plane above the triangle.
  std::optional<OfPlane> to_inside(const Dyadic& radius) const {
    const DyadicVector n = cross(edge[0], edge[1]);
    const Dyadic rate = dot(n, direction);
    if (rate.sign() == 0) return std::nullopt;
    const bool front = rate.sign() < 0;
    const Dyadic height = dot(n, from[0]);
    const OfPlane t{front ? height : -height, radius, dot(n, n), rate.abs(), front};
    for (std::size_t i = 0; i < 3; ++i) {
      const Dyadic begin = dot(n, cross(edge[i], from[i])),
                   step = dot(n, cross(edge[i], direction));
      if (sign_with_root(begin * t.rate + step * t.p, -(step * radius), t.square) < 0) {
        return std::nullopt;
      }
    }
    return t;
  }
};

}  // namespace

RootNumber SphereContact::value() const {
  if (const auto* t = std::get_if<double>(&t_)) return {Dyadic(*t), {}, {}, Dyadic(1.0)};
  if (const auto* q = std::get_if<Quadratic>(&t_)) {
    return {-q->b, Dyadic(-1.0), discriminant(*q), q->a};
  }
  const auto& t = std::get<OfPlane>(t_);
  return {t.p, -t.radius, t.square, t.rate};
}

double SphereContact::rounded() const {
  if (const auto* t = std::get_if<double>(&t_)) return *t;
  return value().rounded();
}

int SphereContact::compare_to(const Dyadic& numerator, const Dyadic& divisor) const {
  return std::visit(
      [&](const auto& t) {
        if constexpr (std::is_same_v<std::decay_t<decltype(t)>, double>) {
          return compare(Dyadic(t) * divisor, numerator);
        } else {
          return compare_root(t, numerator, divisor);
        }
      },
      t_);
}

int compare(const SphereContact& a, const SphereContact& b) {
  const Dyadic one(1.0);
  if (const auto* t = std::get_if<double>(&b.t_)) return a.compare_to(Dyadic(*t), one);
  if (const auto* t = std::get_if<double>(&a.t_)) return -b.compare_to(Dyadic(*t), one);
  const auto* qa = std::get_if<Quadratic>(&a.t_);
  const auto* qb = std::get_if<Quadratic>(&b.t_);
  if (qa != nullptr && qb != nullptr) return compare_roots(*qa, *qb);
  if (qa != nullptr) return -compare_roots(std::get<OfPlane>(b.t_), *qa);
  if (qb != nullptr) return compare_roots(std::get<OfPlane>(a.t_), *qb);
  return compare_roots(std::get<OfPlane>(a.t_), std::get<OfPlane>(b.t_));
}

std::optional<SphereContact> SphereContact::first(const SweepPath& path, const SweptSphere& sphere,
                                                  const Triangle& triangle) {
  if (!is_finite(triangle) || is_degenerate(triangle)) return std::nullopt;
  const bool begins = std::isfinite(path.tmin);
  if (begins && compare(exact_distance(center_at(path, path.tmin), triangle), sphere.radius) <= 0) {
    return SphereContact(path.tmin);
  }
  const Seen seen(path, sphere, triangle);
  std::optional<SphereContact> least;
  const auto offer = [&](const SphereContact& contact) {
    if (!least || compare(contact, *least) < 0) least = contact;
  };
  for (std::size_t i = 0; i < 3; ++i) {
    if (const auto q = seen.to_corner(i)) offer(SphereContact(Part::kCorner, i, *q));
    if (const auto q = seen.to_edge(i)) offer(SphereContact(Part::kEdge, i, *q));
  }
  if (const auto t = seen.to_inside(Dyadic(sphere.radius))) offer(SphereContact(*t));
  if (!least) return std::nullopt;
  const Dyadic one(1.0);
  // It does not touch at tmin: then it has left before, or comes later.
  if (begins && least->compare_to(Dyadic(path.tmin), one) < 0) return std::nullopt;
  if (path.tmin > 0 && !begins) return std::nullopt;
  if (std::isfinite(path.tmax) ? least->compare_to(Dyadic(path.tmax), one) > 0 : path.tmax < 0) {
    return std::nullopt;
  }
  return least;
}

Vec3d SphereContact::position(const SweepPath& path, const SweptSphere& sphere,
                              const Triangle& triangle) const {
  if (const auto* t = std::get_if<double>(&t_)) {
    return nearest_detail(center_at(path, *t), triangle).detail.position;
  }
  const std::array<const Vec3d*, 3> corner{&triangle.v0, &triangle.v1, &triangle.v2};
  if (part_ == Part::kCorner) return *corner[at_];
  const Seen seen(path, sphere, triangle);
  const RootNumber t = value();
  Vec3d point;
  if (part_ == Part::kEdge) {
    // corner + edge (begin + t step) / length
    const DyadicVector& e = seen.edge[at_];
    const Dyadic length = dot(e, e), begin = dot(seen.from[at_], e), step = dot(seen.direction, e);
    const Dyadic part = begin * t.divisor + t.a * step;
    for (int k = 0; k < 3; ++k) {
      const Dyadic& along = e[static_cast<std::size_t>(k)];
      point[k] = RootNumber{Dyadic((*corner[at_])[k]) * length * t.divisor + along * part,
                            along * t.b * step, t.c, length * t.divisor}
                     .rounded();
    }
    return point;
  }
  // The centre, less the radius along the unit normal on its side.
  const auto& plane = std::get<OfPlane>(t_);
  const DyadicVector n = cross(seen.edge[0], seen.edge[1]);
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Dyadic towards = plane.front ? -n[i] : n[i];
    const Dyadic at = Dyadic(path.origin[k]) * plane.rate + plane.p * seen.direction[i];
    point[k] = RootNumber{at * plane.square,
                          plane.radius * (towards * plane.rate - seen.direction[i] * plane.square),
                          plane.square, plane.rate * plane.square}
                   .rounded();
  }
  return point;
}

}  // namespace sightline
