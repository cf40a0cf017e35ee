#include "core/geometry/capsule_sweep.h"

#include <array>
#include <cmath>

#include "core/geometry/exact_hit.h"
#include "core/geometry/point_triangle.h"
#include "core/geometry/triangle_distance.h"

namespace sightline {

namespace {

using Quadratic = CapsuleContact::Quadratic;
using OfPlane = CapsuleContact::OfPlane;

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

/// Of a prism; a sphere has those of the triangle alone.
constexpr std::size_t kPrismCorners = 6, kPrismEdges = 9, kPrismFaces = 5;

/// The way of the capsule's first end as seen from the prism. Corner i < 3 is that of the triangle,
/// corner 3 + i the same moved by `side`. Edge i < 3 goes from corner i to the next one, edge 3 + i
/// the same moved, edge 6 + i from corner i to corner 3 + i. Face 0 is the triangle, face 1 the
/// same moved, face 2 + i lies between edge i and edge 3 + i.
struct Seen {
  DyadicVector direction;
  DyadicVector side;                 ///< from the second end of the capsule to the first one
  std::array<DyadicVector, 6> from;  ///< origin minus corner of the prism
  std::array<DyadicVector, 3> edge;  ///< from corner i of the triangle to the next
  Dyadic square;                     ///< of the radius
  bool is_sphere;

  Seen(const SweepPath& path, const SweptCapsule& capsule, const Triangle& t)
      : direction(exact_vector(path.direction)),
        side(difference(path.origin, capsule.to)),
        from{difference(path.origin, t.v0), difference(path.origin, t.v1),
             difference(path.origin, t.v2), difference(capsule.to, t.v0),
             difference(capsule.to, t.v1),  difference(capsule.to, t.v2)},
        edge{difference(t.v1, t.v0), difference(t.v2, t.v1), difference(t.v0, t.v2)},
        square(Dyadic(capsule.radius) * Dyadic(capsule.radius)),
        is_sphere(capsule.to == path.origin) {}

  const DyadicVector& edge_at(std::size_t i) const { return i < 6 ? edge[i % 3] : side; }
  /// origin minus the edge's begin
  const DyadicVector& from_edge(std::size_t i) const { return from[i < 6 ? i : i - 6]; }
  /// The normal of a face, not of unit length.
  DyadicVector normal_of(std::size_t face) const {
    return face < 2 ? cross(edge[0], edge[1]) : cross(edge[face - 2], side);
  }

  /// The sign of n on the prism's side of a face, 0 if the prism is flat.
  int inner_side(std::size_t face, const DyadicVector& n) const {
    if (is_sphere) return 0;
    if (face < 2) return face == 0 ? dot(n, side).sign() : -dot(n, side).sign();
    return -dot(n, edge[face % 3]).sign();
  }

  std::optional<Quadratic> to_corner(std::size_t i) const {
    const Quadratic q{dot(direction, direction), dot(from[i], direction),
                      dot(from[i], from[i]) - square};
    return discriminant(q).sign() < 0 ? std::nullopt : std::optional(q);
  }

  /// If it comes to the edge's line between the edge's ends.
  std::optional<Quadratic> to_edge(std::size_t i) const {
    const DyadicVector& e = edge_at(i);
    const DyadicVector across = cross(direction, e), beside = cross(from_edge(i), e);
    const Dyadic length = dot(e, e);
    const Quadratic q{dot(across, across), dot(beside, across),
                      dot(beside, beside) - square * length};
    if (q.a.sign() == 0 || discriminant(q).sign() < 0) return std::nullopt;
    // The foot is at (begin + t step) / length of the edge.
    const Dyadic begin = dot(from_edge(i), e), step = dot(direction, e);
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

  /// If it comes to the plane above the face.
  std::optional<OfPlane> to_inside(std::size_t face, const Dyadic& radius) const {
    const DyadicVector n = normal_of(face);
    const Dyadic rate = dot(n, direction);
    if (rate.sign() == 0) return std::nullopt;
    const bool front = rate.sign() < 0;
    // A face that is reached from inside of the prism is not the first part of it that is.
    const int inner = inner_side(face, n);
    if (front ? inner > 0 : inner < 0) return std::nullopt;
    const std::size_t first = face < 2 ? 3 * face : face - 2;
    const Dyadic height = dot(n, from[first]);
    const OfPlane t{front ? height : -height, radius, dot(n, n), rate.abs(), front};
    const auto is_inside = [&](std::size_t corner, const DyadicVector& e, bool turned) {
      const Dyadic begin = dot(n, cross(e, from[corner])), step = dot(n, cross(e, direction));
      const Dyadic value = begin * t.rate + step * t.p, root = step * radius;
      return sign_with_root(turned ? -value : value, turned ? root : -root, t.square) >= 0;
    };
    if (face < 2) {
      for (std::size_t i = 0; i < 3; ++i)
        if (!is_inside(first + i, edge[i], false)) return std::nullopt;
      return t;
    }
    const std::size_t next = (first + 1) % 3;
    if (!is_inside(first, edge[first], false) || !is_inside(next, side, false) ||
        !is_inside(3 + first, edge[first], true) || !is_inside(first, side, true)) {
      return std::nullopt;
    }
    return t;
  }
};

/// The vertex of the triangle that made corner i of a prism.
const Vec3d& vertex(const Triangle& t, std::size_t i) {
  return i % 3 == 0 ? t.v0 : i % 3 == 1 ? t.v1 : t.v2;
}

}  // namespace

RootNumber CapsuleContact::value() const {
  if (const auto* t = std::get_if<double>(&t_)) return {Dyadic(*t), {}, {}, Dyadic(1.0)};
  if (const auto* q = std::get_if<Quadratic>(&t_)) {
    return {-q->b, Dyadic(-1.0), discriminant(*q), q->a};
  }
  const auto& t = std::get<OfPlane>(t_);
  return {t.p, -t.radius, t.square, t.rate};
}

double CapsuleContact::rounded() const {
  if (const auto* t = std::get_if<double>(&t_)) return *t;
  return value().rounded();
}

int CapsuleContact::compare_to(const Dyadic& numerator, const Dyadic& divisor) const {
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

int compare(const CapsuleContact& a, const CapsuleContact& b) {
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

std::optional<CapsuleContact> CapsuleContact::on_line(const SweepPath& path,
                                                      const SweptCapsule& capsule,
                                                      const Triangle& triangle) {
  const Seen seen(path, capsule, triangle);
  std::optional<CapsuleContact> least;
  const auto offer = [&](const CapsuleContact& contact) {
    if (!least || compare(contact, *least) < 0) least = contact;
  };
  // Faces first: at the same time they tell the normal of a capsule without a radius.
  const Dyadic radius(capsule.radius);
  for (std::size_t i = 0; i < (seen.is_sphere ? 1 : kPrismFaces); ++i)
    if (const auto t = seen.to_inside(i, radius)) offer(CapsuleContact(i, *t));
  for (std::size_t i = 0; i < (seen.is_sphere ? 3 : kPrismCorners); ++i)
    if (const auto q = seen.to_corner(i)) offer(CapsuleContact(Part::kCorner, i, *q));
  for (std::size_t i = 0; i < (seen.is_sphere ? 3 : kPrismEdges); ++i)
    if (const auto q = seen.to_edge(i)) offer(CapsuleContact(Part::kEdge, i, *q));
  return least;
}

std::optional<CapsuleContact> CapsuleContact::first(const SweepPath& path,
                                                    const SweptCapsule& capsule,
                                                    const Triangle& triangle) {
  if (!is_finite(triangle) || is_degenerate(triangle)) return std::nullopt;
  const bool begins = std::isfinite(path.tmin);
  if (path.tmin > 0 && !begins) return std::nullopt;
  std::optional<CapsuleContact> enter = on_line(path, capsule, triangle);
  if (!enter) return std::nullopt;
  const Dyadic one(1.0);
  if (begins && enter->compare_to(Dyadic(path.tmin), one) < 0) {
    // It leaves where it enters on the way back.
    const Vec3d back{-path.direction.x, -path.direction.y, -path.direction.z};
    const auto leave = on_line({path.origin, back, 0, 0}, capsule, triangle);
    if (!leave || leave->compare_to(Dyadic(-path.tmin), one) > 0) return std::nullopt;
    return CapsuleContact(path.tmin);
  }
  if (std::isfinite(path.tmax) ? enter->compare_to(Dyadic(path.tmax), one) > 0 : path.tmax < 0) {
    return std::nullopt;
  }
  return enter;
}

Vec3d CapsuleContact::position(const SweepPath& path, const SweptCapsule& capsule,
                               const Triangle& triangle) const {
  const Seen seen(path, capsule, triangle);
  if (const auto* t = std::get_if<double>(&t_)) {
    if (seen.is_sphere) return nearest_detail(center_at(path, *t), triangle).detail.position;
    std::array<Vec3d, 2> ends{path.origin, capsule.to};
    for (int k = 0; k < 3; ++k) {
      const Dyadic step = Dyadic(*t) * Dyadic(path.direction[k]), one(1.0);
      for (Vec3d& end : ends) end[k] = round_quotient(Dyadic(end[k]) + step, one);
    }
    return nearest_pair(ends[0] == ends[1] ? Corners(ends).first(1) : Corners(ends), triangle).on_b;
  }
  if (part_ == Part::kCorner) return vertex(triangle, at_);
  const RootNumber t = value();
  Vec3d point;
  if (part_ == Part::kEdge) {
    // Along an edge that a corner makes the triangle's point is the corner.
    if (at_ >= 6) return vertex(triangle, at_);
    // corner + edge (begin + t step) / length
    const DyadicVector &e = seen.edge_at(at_), &from = seen.from_edge(at_);
    const Dyadic length = dot(e, e), begin = dot(from, e), step = dot(seen.direction, e);
    const Dyadic part = begin * t.divisor + t.a * step;
    for (int k = 0; k < 3; ++k) {
      const Dyadic& along = e[static_cast<std::size_t>(k)];
      point[k] = RootNumber{Dyadic(vertex(triangle, at_)[k]) * length * t.divisor + along * part,
                            along * t.b * step, t.c, length * t.divisor}
                     .rounded();
    }
    return point;
  }
  const auto& plane = std::get<OfPlane>(t_);
  const DyadicVector n = seen.normal_of(at_);
  if (at_ >= 2) {
    // corner + edge ((origin + t direction - corner) x side) . n / n . n: what lies along `side` or
    // along n does not count.
    const std::size_t i = at_ - 2;
    const Dyadic begin = dot(cross(seen.from[i], seen.side), n),
                 step = dot(cross(seen.direction, seen.side), n);
    const Dyadic divisor = plane.square * t.divisor, part = begin * t.divisor + t.a * step;
    for (int k = 0; k < 3; ++k) {
      const Dyadic& along = seen.edge[i][static_cast<std::size_t>(k)];
      point[k] = RootNumber{Dyadic(vertex(triangle, i)[k]) * divisor + along * part,
                            along * t.b * step, t.c, divisor}
                     .rounded();
    }
    return point;
  }
  // The end, less the radius along the unit normal on its side.
  const Vec3d& end = at_ == 0 ? path.origin : capsule.to;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Dyadic towards = plane.front ? -n[i] : n[i];
    const Dyadic at = Dyadic(end[k]) * plane.rate + plane.p * seen.direction[i];
    point[k] = RootNumber{at * plane.square,
                          plane.radius * (towards * plane.rate - seen.direction[i] * plane.square),
                          plane.square, plane.rate * plane.square}
                   .rounded();
  }
  return point;
}

std::optional<Vec3d> CapsuleContact::normal(const SweepPath& path, const SweptCapsule& capsule,
                                            const Triangle& triangle) const {
  if (std::holds_alternative<double>(t_)) return std::nullopt;
  const Seen seen(path, capsule, triangle);
  Vec3d normal;
  if (part_ == Part::kInside) {
    const auto& plane = std::get<OfPlane>(t_);
    const DyadicVector n = seen.normal_of(at_);
    for (int k = 0; k < 3; ++k) {
      const Dyadic& along = n[static_cast<std::size_t>(k)];
      normal[k] = round_over_root(plane.front ? along : -along, plane.square);
    }
    return normal;
  }
  if (capsule.radius == 0) return std::nullopt;
  const RootNumber t = value();
  const Dyadic radius(capsule.radius);
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    // from + t direction for a corner; for an edge without its part along the edge.
    Dyadic from = seen.from[at_ % 6][i], step = seen.direction[i], divisor = radius;
    if (part_ == Part::kEdge) {
      const DyadicVector& e = seen.edge_at(at_);
      const DyadicVector& begin = seen.from_edge(at_);
      const Dyadic length = dot(e, e);
      from = begin[i] * length - e[i] * dot(begin, e);
      step = step * length - e[i] * dot(seen.direction, e);
      divisor = divisor * length;
    }
    normal[k] =
        RootNumber{from * t.divisor + step * t.a, step * t.b, t.c, divisor * t.divisor}.rounded();
  }
  return normal;
}

}  // namespace sightline
