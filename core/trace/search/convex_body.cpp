#include "core/trace/search/convex_body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/float64_vector.h"
#include "core/geometry/triangle_crossing.h"

namespace sightline {
namespace {

auto key_of(const Vec3d& p) { return std::tuple(p.x, p.y, p.z); }

}  // namespace

std::optional<ConvexBody> ConvexBody::of(std::span<const Triangle> triangles) {
  if (triangles.empty() || triangles.size() > kMostTriangles) return std::nullopt;
  ConvexBody body;
  using Key = std::tuple<double, double, double>;
  std::map<std::pair<Key, Key>, std::pair<Segment, int>> edges;
  for (const Triangle& t : triangles) {
    const std::array<Vec3d, 3> corner{t.v0, t.v1, t.v2};
    body.corners_.insert(body.corners_.end(), corner.begin(), corner.end());
    body.faces_.push_back({{t.v0, t.v1}, {t.v0, t.v2}});
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d &p = corner[i], &q = corner[(i + 1) % 3];
      const auto place = edges.try_emplace(std::minmax(key_of(p), key_of(q)), Segment{p, q}, 0);
      ++place.first->second.second;
    }
  }
  for (const auto& [key, edge] : edges) {
    if (edge.second != 2) return std::nullopt;
    body.edges_.push_back(edge.first);
  }
  const auto comes_before = [](const Vec3d& p, const Vec3d& q) { return key_of(p) < key_of(q); };
  const auto is_same = [](const Vec3d& p, const Vec3d& q) { return key_of(p) == key_of(q); };
  std::sort(body.corners_.begin(), body.corners_.end(), comes_before);
  body.corners_.erase(std::unique(body.corners_.begin(), body.corners_.end(), is_same),
                      body.corners_.end());
  for (const Triangle& t : triangles) {
    int least = 0, most = 0;
    for (const Vec3d& p : body.corners_) {
      const int side = volume_sign(t.v0, t.v1, t.v2, p);
      least = std::min(least, side);
      most = std::max(most, side);
    }
    // A flat body has no inside.
    if ((least < 0) == (most > 0)) return std::nullopt;
  }
  return body;
}

/// One search for the axis of the least overlap.
class PenetrationSearch {
 public:
  PenetrationSearch(const ConvexBody& a, const ConvexBody& b)
      : a_(a), b_(b), origin_(a.corners_[0]) {
    for (const auto* body : {&a, &b}) {
      for (const Vec3d& p : body->corners_)
        size_ = std::max(size_, float64::largest(float64::minus(p, origin_)));
    }
  }

  std::optional<ExactDistance> find(const Deadline& deadline) {
    for (const auto* body : {&a_, &b_}) {
      for (const auto& [e, f] : body->faces_) estimate(e, f);
    }
    for (const auto& e : a_.edges_) {
      if (deadline.passed()) return std::nullopt;
      for (const auto& f : b_.edges_) estimate(e, f);
    }
    for (const Axis& axis : axes_) {
      if (axis.low > high_) continue;
      if (deadline.passed()) return std::nullopt;
      if (!decide(axis)) return ExactDistance{};
    }
    return best_;
  }

 private:
  using Segment = ConvexBody::Segment;
  struct Axis {
    const Segment *e, *f;
    double low;  ///< at most the overlap
  };

  /// Computes the overlap along e x f in float64. The error of the axis is relative to |e| |f|,
  /// that of a corner to the size of both bodies.
  void estimate(const Segment& e, const Segment& f) {
    using namespace float64;
    const Numbers d = minus(e[1], e[0]), g = minus(f[1], f[0]), n = cross(d, g);
    const double length = std::sqrt(dot(n, n));
    const double error =
        0x1p-46 * size_ * (1 + std::sqrt(dot(d, d)) * std::sqrt(dot(g, g)) / length);
    // Axes that are nearly zero, and sizes whose squares may overflow, are decided exactly.
    if (!(error < size_) || !(size_ < 0x1p200) || size_ < 0x1p-200) {
      axes_.push_back({&e, &f, -std::numeric_limits<double>::infinity()});
      return;
    }
    const auto [least_a, most_a] = range(a_, n);
    const auto [least_b, most_b] = range(b_, n);
    const double overlap = std::min(most_a - least_b, most_b - least_a) / length;
    if (overlap - error > high_) return;
    high_ = std::min(high_, overlap + error);
    axes_.push_back({&e, &f, overlap - error});
  }

  std::pair<double, double> range(const ConvexBody& body, const float64::Numbers& n) const {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const Vec3d& p : body.corners_) {
      const double along = float64::dot(n, float64::minus(p, origin_));
      least = std::min(least, along);
      most = std::max(most, along);
    }
    return {least, most};
  }

  std::pair<Dyadic, Dyadic> exact_range(const ConvexBody& body, const DyadicVector& n) const {
    std::pair<Dyadic, Dyadic> range;
    bool is_first = true;
    for (const Vec3d& p : body.corners_) {
      const Dyadic along = dot(n, difference(p, origin_));
      if (is_first || along < range.first) range.first = along;
      if (is_first || range.second < along) range.second = along;
      is_first = false;
    }
    return range;
  }

  /// Compares an axis with the best one, exactly. Returns false if the interiors are separate.
  bool decide(const Axis& axis) {
    const auto& [e, f, low] = axis;
    const DyadicVector n = cross(difference((*e)[1], (*e)[0]), difference((*f)[1], (*f)[0]));
    const Dyadic square = dot(n, n);
    if (square.sign() == 0) return true;
    const auto of_a = exact_range(a_, n), of_b = exact_range(b_, n);
    const Dyadic one = of_a.second - of_b.first, other = of_b.second - of_a.first;
    const Dyadic& overlap = one < other ? one : other;
    if (overlap.sign() <= 0) return false;
    const ExactDistance depth{overlap * overlap, square};
    if (!best_ || compare(depth, *best_) < 0) best_ = depth;
    return true;
  }

  const ConvexBody &a_, &b_;
  const Vec3d origin_;
  double size_ = 0;
  double high_ = std::numeric_limits<double>::infinity();  ///< at least the least overlap
  std::vector<Axis> axes_;
  std::optional<ExactDistance> best_;
};

std::optional<ExactDistance> penetration_depth(const ConvexBody& a, const ConvexBody& b,
                                               const Deadline& deadline) {
  return PenetrationSearch(a, b).find(deadline);
}

}  // namespace sightline
