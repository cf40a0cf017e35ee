#include "core/geometry/convex/penetration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/geometry/float64_vector.h"
#include "core/geometry/rounding.h"

namespace sightline {
namespace {

DyadicVector negated(const DyadicVector& v) { return {-v[0], -v[1], -v[2]}; }

/// Sign of a_k / |a| - b_k / |b| for the first k where they differ.
int compare_directions(const DyadicVector& a, const Dyadic& square_a, const DyadicVector& b,
                       const Dyadic& square_b) {
  for (std::size_t k = 0; k < 3; ++k) {
    const int sign = a[k].sign();
    if (sign != b[k].sign()) return sign < b[k].sign() ? -1 : 1;
    const int order = compare(a[k] * a[k] * square_b, b[k] * b[k] * square_a);
    if (order != 0) return sign * order;
  }
  return 0;
}

/// One search for the direction of the least overlap.
class PenetrationSearch {
 public:
  PenetrationSearch(const ConvexParts& a, const ConvexParts& b)
      : a_(a), b_(b), origin_(b.corners[0]) {
    for (const auto* body : {&a, &b}) {
      for (const Vec3d& p : body->corners)
        size_ = std::max(size_, float64::largest(float64::minus(p, origin_)));
    }
  }

  std::optional<Penetration> find(const Deadline& deadline) {
    for (const auto& [e, f] : b_.faces) estimate(e, f, true);
    for (const auto& [e, f] : a_.faces) estimate(e, f, false);
    for (const auto& e : a_.edges) {
      if (deadline.passed()) return std::nullopt;
      for (const auto& f : b_.edges) estimate(e, f, false);
    }
    for (const Axis& axis : axes_) {
      if (axis.low > high_) continue;
      if (deadline.passed()) return std::nullopt;
      if (!decide(axis)) return Penetration{};
    }
    return least_.best() ? least_.best() : Penetration{};
  }

 private:
  struct Axis {
    const Segment *e, *f;
    double low;  ///< at most the overlap
    bool is_face_of_b;
  };

  /// Computes the overlap along e x f in float64. The error of the axis is relative to |e| |f|,
  /// that of a corner to the size of both bodies.
  void estimate(const Segment& e, const Segment& f, bool is_face_of_b) {
    using namespace float64;
    const Numbers d = minus(e[1], e[0]), g = minus(f[1], f[0]), n = cross(d, g);
    const double length = std::sqrt(dot(n, n));
    const double error =
        0x1p-46 * size_ * (1 + std::sqrt(dot(d, d)) * std::sqrt(dot(g, g)) / length);
    // Axes that are nearly zero, and sizes whose squares may overflow, are decided exactly.
    if (!(error < size_) || !(size_ < 0x1p200) || size_ < 0x1p-200) {
      axes_.push_back({&e, &f, -kInfD, is_face_of_b});
      return;
    }
    const auto [least_a, most_a] = range(a_, n);
    const auto [least_b, most_b] = range(b_, n);
    const double overlap = std::min(most_a - least_b, most_b - least_a) / length;
    if (overlap - error > high_) return;
    high_ = std::min(high_, overlap + error);
    axes_.push_back({&e, &f, overlap - error, is_face_of_b});
  }

  std::pair<double, double> range(const ConvexParts& body, const float64::Numbers& n) const {
    double least = kInfD, most = -kInfD;
    for (const Vec3d& p : body.corners) {
      const double along = float64::dot(n, float64::minus(p, origin_));
      least = std::min(least, along);
      most = std::max(most, along);
    }
    return {least, most};
  }

  std::pair<Dyadic, Dyadic> exact_range(const ConvexParts& body, const DyadicVector& n) const {
    std::pair<Dyadic, Dyadic> range;
    bool is_first = true;
    for (const Vec3d& p : body.corners) {
      const Dyadic along = dot(n, difference(p, origin_));
      if (is_first || along < range.first) range.first = along;
      if (is_first || range.second < along) range.second = along;
      is_first = false;
    }
    return range;
  }

  /// Compares both directions of an axis with the best one, exactly. Returns false if the bodies
  /// have no common point.
  bool decide(const Axis& axis) {
    const Segment &e = *axis.e, &f = *axis.f;
    const DyadicVector n = cross(difference(e[1], e[0]), difference(f[1], f[0]));
    if (n[0].sign() == 0 && n[1].sign() == 0 && n[2].sign() == 0) return true;
    const auto of_a = exact_range(a_, n), of_b = exact_range(b_, n);
    const Dyadic forth = of_b.second - of_a.first, back = of_a.second - of_b.first;
    if (forth.sign() < 0 || back.sign() < 0) return false;
    least_.offer(n, forth, axis.is_face_of_b ? 0 : 2);
    least_.offer(negated(n), back, axis.is_face_of_b ? 1 : 2);
    return true;
  }

  const ConvexParts &a_, &b_;
  const Vec3d origin_;
  double size_ = 0;
  double high_ = kInfD;  ///< at least the least overlap
  std::vector<Axis> axes_;
  LeastPenetration least_;
};

}  // namespace

void LeastPenetration::offer(const DyadicVector& n, const Dyadic& overlap, int rank) {
  const ExactDistance depth{overlap * overlap, dot(n, n)};
  if (best_) {
    const int order = compare(depth, best_->depth);
    if (order > 0 || (order == 0 && rank > rank_)) return;
    if (order == 0 && rank == rank_ &&
        compare_directions(n, depth.divisor, best_->direction, best_->depth.divisor) <= 0) {
      return;
    }
  }
  best_ = Penetration{depth, n};
  rank_ = rank;
}

std::optional<Penetration> penetration(const ConvexParts& a, const ConvexParts& b,
                                       const Deadline& deadline) {
  return PenetrationSearch(a, b).find(deadline);
}

}  // namespace sightline
