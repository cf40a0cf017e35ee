#include "core/geometry/triangle_distance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/float64_vector.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

using namespace float64;

/// A point of at most three corners: weights of the second and the third.
using Weights = std::array<double, 2>;

struct SeenCorners {
  std::array<Numbers, 3> corner{};
  std::size_t count = 0;

  Numbers at(const Weights& w) const {
    Numbers p = corner[0];
    for (std::size_t i = 1; i < count; ++i) {
      for (std::size_t k = 0; k < 3; ++k) p[k] += w[i - 1] * (corner[i][k] - corner[0][k]);
    }
    return p;
  }
  std::size_t edges() const { return count == 3 ? 3 : count - 1; }
};

SeenCorners seen_from(const Vec3d& origin, Corners corners) {
  SeenCorners seen;
  seen.count = corners.size();
  for (std::size_t i = 0; i < seen.count; ++i) seen.corner[i] = minus(corners[i], origin);
  return seen;
}

double clamped(double part) { return part > 0 ? std::min(part, 1.0) : 0; }

/// Near those of the point nearest to p; of some point of it in any case.
Weights weights_near(const SeenCorners& of, const Numbers& p) {
  if (of.count == 1) return {0, 0};
  const Numbers first = minus(of.corner[1], of.corner[0]);
  if (of.count == 2) return {clamped(dot(minus(p, of.corner[0]), first) / dot(first, first)), 0};
  std::array<Numbers, 3> from_p;
  for (std::size_t i = 0; i < 3; ++i) from_p[i] = minus(of.corner[i], p);
  return near_weights(from_p, first, minus(of.corner[2], of.corner[0]));
}

/// The point at `part` of the way along edge i.
Weights on_edge(const SeenCorners& of, std::size_t i, double part) {
  if (of.count == 2) return {part, 0};
  if (i == 0) return {part, 0};
  if (i == 1) return {1 - part, part};
  return {0, 1 - part};
}

/// From a point of b to a point of a that is about nearest, and the other way round.
Numbers near_difference(const SeenCorners& a, const SeenCorners& b) {
  Numbers best{};
  double least = kInfD;
  const auto offer = [&](const Weights& on_a, const Weights& on_b) {
    const Numbers d = minus(b.at(on_b), a.at(on_a));
    const double square = dot(d, d);
    if (!(square < least)) return;
    least = square;
    best = d;
  };
  constexpr std::array<Weights, 3> kCorner{{{0, 0}, {1, 0}, {0, 1}}};
  for (std::size_t i = 0; i < a.count; ++i) offer(kCorner[i], weights_near(b, a.corner[i]));
  for (std::size_t j = 0; j < b.count; ++j) offer(weights_near(a, b.corner[j]), kCorner[j]);
  for (std::size_t i = 0; i < a.edges(); ++i) {
    const Numbers& p = a.corner[i];
    const Numbers d = minus(a.corner[(i + 1) % a.count], p);
    for (std::size_t j = 0; j < b.edges(); ++j) {
      const Numbers& q = b.corner[j];
      const Numbers e = minus(b.corner[(j + 1) % b.count], q), w = minus(q, p);
      const Numbers n = cross(d, e);
      const double square = dot(n, n);
      if (!(square > 0)) continue;
      offer(on_edge(a, i, clamped(dot(cross(w, e), n) / square)),
            on_edge(b, j, clamped(dot(cross(w, d), n) / square)));
    }
  }
  return best;
}

}  // namespace

DistanceRange distance_range(Corners a_corners, Corners b_corners) {
  const SeenCorners a = seen_from(b_corners[0], a_corners), b = seen_from(b_corners[0], b_corners);
  double size = 0;
  for (const SeenCorners* seen : {&a, &b}) {
    for (std::size_t i = 0; i < seen->count; ++i) {
      // NaN becomes the size.
      const double x = largest(seen->corner[i]);
      if (!(x <= size)) size = x;
    }
  }
  if (!(size < 0x1p400) || size < 0x1p-400) return {0, kInfD};
  const Numbers near = near_difference(a, b);
  const double error = 256 * kU * size;
  const double length = std::sqrt(dot(near, near));
  DistanceRange range{0, length + error};
  if (length <= error) return range;
  // Nothing is nearer than the two are along `near`.
  double most = -kInfD, least = kInfD;
  for (std::size_t i = 0; i < a.count; ++i) most = std::max(most, dot(a.corner[i], near));
  for (std::size_t j = 0; j < b.count; ++j) least = std::min(least, dot(b.corner[j], near));
  range.low = std::max(0.0, (least - most) / length - error);
  return range;
}

namespace {

/// Two edges whose lines are nearest at s and t, over `divisor`, of their lengths.
struct EdgePair {
  DyadicVector p, d;  ///< begin, as the other one's begin sees it, and direction; of edge a
  DyadicVector e;     ///< direction of edge b
  Dyadic s, t, divisor, height;
  bool inside = false;  ///< of both

  EdgePair(const Vec3d& a0, const Vec3d& a1, const Vec3d& b0, const Vec3d& b1)
      : d(difference(a1, a0)), e(difference(b1, b0)) {
    const DyadicVector n = cross(d, e);
    divisor = dot(n, n);
    if (divisor.sign() == 0) return;
    const DyadicVector w = difference(b0, a0);
    s = dot(cross(w, e), n);
    t = dot(cross(w, d), n);
    inside = is_part(s) && is_part(t);
    if (inside) height = dot(w, n);
  }
  bool is_part(const Dyadic& x) const { return x.sign() >= 0 && compare(x, divisor) <= 0; }
  ExactDistance distance() const { return {height * height, divisor}; }
};

/// Where the segment goes through the triangle, at `part` over `divisor` of its length. Segments
/// that touch an edge or lie in the plane may or may not be met: other parts tell of them.
struct Passage {
  bool met = false;
  Dyadic part, divisor;

  Passage(const Vec3d& from, const Vec3d& to, const Triangle& through) {
    const DyadicVector d = difference(to, from);
    const std::array<DyadicVector, 3> c{difference(through.v0, from), difference(through.v1, from),
                                        difference(through.v2, from)};
    const DyadicVector bc = cross(c[1], c[2]);
    const Dyadic w0 = dot(d, bc), w1 = dot(d, cross(c[2], c[0])), w2 = dot(d, cross(c[0], c[1]));
    if (w0.sign() * w1.sign() < 0 || w1.sign() * w2.sign() < 0 || w0.sign() * w2.sign() < 0) return;
    divisor = w0 + w1 + w2;
    if (divisor.sign() == 0) return;
    part = dot(c[0], bc);
    if (divisor.sign() < 0) {
      divisor = -divisor;
      part = -part;
    }
    met = part.sign() >= 0 && compare(part, divisor) <= 0;
  }
};

/// begin + part / divisor * (end - begin), each coordinate rounded once.
Vec3d point_between(const Vec3d& begin, const Vec3d& end, const Dyadic& part,
                    const Dyadic& divisor) {
  Vec3d point;
  for (int k = 0; k < 3; ++k) {
    const Dyadic step = Dyadic(end[k]) - Dyadic(begin[k]);
    point[k] = round_quotient(Dyadic(begin[k]) * divisor + part * step, divisor);
  }
  return point;
}

std::size_t edges_of(Corners c) { return c.size() == 3 ? 3 : c.size() - 1; }
Triangle triangle_of(Corners c) { return {c[0], c[1], c[2]}; }

/// The nearest points of both, by trying the parts of which one must have them.
class NearestParts {
 public:
  NearestParts(Corners a, const Triangle& b) : a_(a), b_(corners_of(b)), triangle_b_(b) {
    high_ = distance_range(a_, b_).high;
    for (std::size_t i = 0; i < a_.size(); ++i) {
      if (is_near(distance_range(a_[i], triangle_b_)))
        offer(exact_distance(a_[i], triangle_b_), Kind::kCornerOfA, i, 0);
    }
    for (std::size_t j = 0; j < 3; ++j) try_corner_of_b(j);
    for (std::size_t i = 0; i < edges_of(a_); ++i) {
      for (std::size_t j = 0; j < 3; ++j) try_edges(i, j);
    }
    if (is_zero()) return;
    for (std::size_t i = 0; i < edges_of(a_) && !is_zero(); ++i) {
      if (Passage(a_[i], next_of(a_, i), triangle_b_).met) offer({}, Kind::kEdgeOfA, i, 0);
    }
    for (std::size_t j = 0; j < 3 && a_.size() == 3 && !is_zero(); ++j) {
      if (Passage(b_[j], next_of(b_, j), triangle_of(a_)).met) offer({}, Kind::kEdgeOfB, 0, j);
    }
  }

  const ExactDistance& distance() const { return least_; }

  /// From the point of b to the point of a. Precondition: they differ.
  DyadicVector away() const {
    DyadicVector v;
    if (kind_ == Kind::kCornerOfA) return away_from(triangle_b_, a_[i_]);
    if (kind_ == Kind::kCornerOfB && a_.size() == 3) {
      v = away_from(triangle_of(a_), b_[j_]);
      for (Dyadic& x : v) x = -x;
    } else if (kind_ == Kind::kCornerOfB) {
      const auto [along, length] = on_segment(b_[j_]);
      const DyadicVector d = difference(a_[1], a_[0]), w = difference(b_[j_], a_[0]);
      for (std::size_t k = 0; k < 3; ++k) v[k] = d[k] * along - w[k] * length;
    } else {
      const EdgePair pair(a_[i_], next_of(a_, i_), b_[j_], next_of(b_, j_));
      v = cross(pair.d, pair.e);
      if (pair.height.sign() > 0) {
        for (Dyadic& x : v) x = -x;
      }
    }
    return v;
  }

  NearestPair points() const {
    switch (kind_) {
      case Kind::kCornerOfA:
        return {a_[i_], nearest_detail(a_[i_], triangle_b_).detail.position};
      case Kind::kCornerOfB:
        if (a_.size() == 3)
          return {nearest_detail(b_[j_], triangle_of(a_)).detail.position, b_[j_]};
        {
          const auto [along, length] = on_segment(b_[j_]);
          return {point_between(a_[0], a_[1], along, length), b_[j_]};
        }
      case Kind::kEdges: {
        const EdgePair pair(a_[i_], next_of(a_, i_), b_[j_], next_of(b_, j_));
        return {point_between(a_[i_], next_of(a_, i_), pair.s, pair.divisor),
                point_between(b_[j_], next_of(b_, j_), pair.t, pair.divisor)};
      }
      case Kind::kEdgeOfA:
      case Kind::kEdgeOfB:
        break;
    }
    const bool is_a = kind_ == Kind::kEdgeOfA;
    const Corners edge_of = is_a ? a_ : b_;
    const std::size_t i = is_a ? i_ : j_;
    const Passage passage(edge_of[i], next_of(edge_of, i), is_a ? triangle_b_ : triangle_of(a_));
    const Vec3d at = point_between(edge_of[i], next_of(edge_of, i), passage.part, passage.divisor);
    return {at, at};
  }

 private:
  enum class Kind { kCornerOfA, kCornerOfB, kEdges, kEdgeOfA, kEdgeOfB };

  static const Vec3d& next_of(Corners c, std::size_t i) { return c[(i + 1) % c.size()]; }
  bool is_near(const DistanceRange& range) const { return range.low <= high_; }
  bool is_zero() const { return found_ && least_.square.sign() == 0; }

  void offer(const ExactDistance& distance, Kind kind, std::size_t i, std::size_t j) {
    if (found_ && compare(distance, least_) >= 0) return;
    found_ = true;
    least_ = distance;
    kind_ = kind;
    i_ = i;
    j_ = j;
  }

  /// How far along the segment the point is, and the segment's squared length.
  std::array<Dyadic, 2> on_segment(const Vec3d& point) const {
    const DyadicVector d = difference(a_[1], a_[0]);
    return {dot(difference(point, a_[0]), d), dot(d, d)};
  }

  void try_corner_of_b(std::size_t j) {
    if (a_.size() == 3) {
      const Triangle a = triangle_of(a_);
      if (is_near(distance_range(b_[j], a)))
        offer(exact_distance(b_[j], a), Kind::kCornerOfB, 0, j);
      return;
    }
    // The ends of the segment have been tried.
    const auto [along, length] = on_segment(b_[j]);
    if (along.sign() <= 0 || compare(along, length) >= 0) return;
    const DyadicVector side = cross(difference(b_[j], a_[0]), difference(a_[1], a_[0]));
    offer({dot(side, side), length}, Kind::kCornerOfB, 0, j);
  }

  void try_edges(std::size_t i, std::size_t j) {
    const std::array<Vec3d, 2> a{a_[i], next_of(a_, i)}, b{b_[j], next_of(b_, j)};
    if (!is_near(distance_range(Corners(a), Corners(b)))) return;
    const EdgePair pair(a[0], a[1], b[0], b[1]);
    if (pair.inside) offer(pair.distance(), Kind::kEdges, i, j);
  }

  const Corners a_, b_;
  const Triangle triangle_b_;
  double high_ = 0;  ///< at least the distance
  bool found_ = false;
  ExactDistance least_;
  Kind kind_ = Kind::kCornerOfA;
  std::size_t i_ = 0, j_ = 0;
};

}  // namespace

ExactDistance exact_distance(Corners a, const Triangle& b) { return NearestParts(a, b).distance(); }

DyadicVector away_from(const Triangle& b, Corners a) { return NearestParts(a, b).away(); }

NearestPair nearest_pair(Corners a, const Triangle& b) { return NearestParts(a, b).points(); }

}  // namespace sightline
