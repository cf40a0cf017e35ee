#include "core/geometry/convex/shape_contact.h"

#include <array>
#include <cmath>
#include <optional>

#include "core/geometry/root.h"
#include "core/geometry/rounding.h"
#include "core/geometry/triangle_distance.h"

namespace sightline {
namespace {

/// A triangle as a body.
struct TriangleParts {
  std::array<Vec3d, 3> corners;
  std::array<Segment, 3> edges;
  std::array<std::array<Segment, 2>, 1> faces;

  explicit TriangleParts(const Triangle& t)
      : corners{t.v0, t.v1, t.v2},
        edges{{{t.v0, t.v1}, {t.v1, t.v2}, {t.v2, t.v0}}},
        faces{{{Segment{t.v0, t.v1}, Segment{t.v0, t.v2}}}} {}
  ConvexParts parts() const { return {corners, edges, faces}; }
};

Vec3d unit(const DyadicVector& v) {
  const Dyadic square = dot(v, v);
  return {round_over_root(v[0], square), round_over_root(v[1], square),
          round_over_root(v[2], square)};
}

/// A box in numbers in which both kinds are one: the points p with low <= normal . (p - origin) <=
/// high for three normals. A bound that is missing leaves the box open.
struct ExactBox {
  std::array<DyadicVector, 3> normals;
  std::array<std::optional<Dyadic>, 3> low, high;
};

/// The box's edges: edge i is across normals j and k. Its product with normal i is `weight`.
struct BoxEdges {
  std::array<DyadicVector, 3> edges;
  Dyadic weight;

  explicit BoxEdges(const ExactBox& box) {
    for (std::size_t i = 0; i < 3; ++i)
      edges[i] = cross(box.normals[(i + 1) % 3], box.normals[(i + 2) % 3]);
    weight = dot(edges[0], box.normals[0]);
    if (weight.sign() > 0) return;
    weight = -weight;
    for (DyadicVector& edge : edges) {
      for (Dyadic& x : edge) x = -x;
    }
  }
};

/// The least n . (p - origin) of a box, times the weight; empty if there is none.
std::optional<Dyadic> least_along(const DyadicVector& n, const ExactBox& box,
                                  const BoxEdges& edges) {
  Dyadic least;
  for (std::size_t i = 0; i < 3; ++i) {
    const Dyadic rate = dot(n, edges.edges[i]);
    if (rate.sign() == 0) continue;
    const std::optional<Dyadic>& bound = rate.sign() > 0 ? box.low[i] : box.high[i];
    if (!bound) return std::nullopt;
    least = least + rate * *bound;
  }
  return least;
}

/// The origin is the first corner of the triangle.
ShapeContact contact_of(const ExactBox& box, const Triangle& triangle) {
  const BoxEdges edges(box);
  const DyadicVector ab = difference(triangle.v1, triangle.v0),
                     ac = difference(triangle.v2, triangle.v0),
                     bc = difference(triangle.v2, triangle.v1);
  LeastPenetration found;
  const auto offer = [&](DyadicVector n, int forth_rank, int back_rank) {
    for (const int rank : {forth_rank, back_rank}) {
      const std::optional<Dyadic> least = least_along(n, box, edges);
      if (least && (n[0].sign() != 0 || n[1].sign() != 0 || n[2].sign() != 0)) {
        Dyadic most;
        for (const DyadicVector* corner : {&ab, &ac}) {
          const Dyadic along = dot(n, *corner);
          if (most < along) most = along;
        }
        found.offer(n, most * edges.weight - *least, rank);
      }
      for (Dyadic& x : n) x = -x;
    }
  };
  offer(cross(ab, ac), 0, 1);
  for (const DyadicVector& n : box.normals) offer(n, 2, 2);
  for (const DyadicVector& e : edges.edges) {
    for (const DyadicVector* f : {&ab, &ac, &bc}) offer(cross(e, *f), 2, 2);
  }
  if (!found.best()) return {kInfD, {}};
  ExactDistance depth = found.best()->depth;
  depth.divisor = depth.divisor * edges.weight * edges.weight;
  return {depth.rounded(), unit(found.best()->direction)};
}

}  // namespace

ShapeContact contact_of(const Box3d& box, const Triangle& triangle) {
  ExactBox exact;
  for (std::size_t k = 0; k < 3; ++k) {
    const int i = static_cast<int>(k);
    const Dyadic origin(triangle.v0[i]);
    exact.normals[k][k] = Dyadic(1.0);
    if (std::isfinite(box.min[i])) exact.low[k] = Dyadic(box.min[i]) - origin;
    if (std::isfinite(box.max[i])) exact.high[k] = Dyadic(box.max[i]) - origin;
  }
  return contact_of(exact, triangle);
}

ShapeContact contact_of(const OrientedBox& box, const Triangle& triangle) {
  ExactBox exact;
  const DyadicVector center = difference(box.center, triangle.v0);
  for (std::size_t k = 0; k < 3; ++k) {
    exact.normals[k] = exact_vector(box.axes[k]);
    const double half = box.half[static_cast<int>(k)];
    if (!std::isfinite(half)) continue;
    const Dyadic middle = dot(exact.normals[k], center);
    exact.low[k] = middle - Dyadic(half);
    exact.high[k] = middle + Dyadic(half);
  }
  return contact_of(exact, triangle);
}

ShapeContact contact_of(const Capsule& capsule, const Triangle& triangle) {
  const Segment axis{capsule.from, capsule.to};
  const Dyadic radius(capsule.radius);
  const auto contact = [&](const ExactDistance& beyond, double sign, const DyadicVector& along) {
    const RootNumber depth{radius * beyond.divisor, Dyadic(sign), beyond.square * beyond.divisor,
                           beyond.divisor};
    return ShapeContact{depth.rounded(), unit(along)};
  };
  const ExactDistance distance = exact_distance(axis, triangle);
  if (distance.square.sign() > 0) return contact(distance, -1, away_from(triangle, axis));
  const TriangleParts other(triangle);
  const bool is_point = capsule.from == capsule.to;
  const ConvexParts core{
      std::span(axis).first(is_point ? 1 : 2), std::span(&axis, is_point ? 0 : 1), {}};
  const Penetration inner = *penetration(core, other.parts(), Deadline::never());
  return contact(inner.depth, 1, inner.direction);
}

std::optional<ShapeContact> contact_of(const BodyParts& hull, const Triangle& triangle,
                                       const Deadline& deadline) {
  const TriangleParts other(triangle);
  const auto found = penetration(hull.parts(), other.parts(), deadline);
  if (!found) return std::nullopt;
  return ShapeContact{found->depth.rounded(), unit(found->direction)};
}

}  // namespace sightline
