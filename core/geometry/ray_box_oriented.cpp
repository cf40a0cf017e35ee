/// Oriented boxes: the same decisions as for axis-aligned ones, over slabs whose distances and
/// rates are dot products. With S = a . (o - c) and R = a . d the planes are at depth h + S and h -
/// S, and t = -depth / |R| where the line enters, depth / |R| where it leaves.

#include <cmath>

#include "core/geometry/box_bounds.h"
#include "core/geometry/dyadic.h"
#include "core/geometry/dyadic_vector.h"
#include "core/geometry/error_free.h"
#include "core/geometry/ray_box.h"
#include "core/geometry/ray_box_decide.h"

namespace sightline {

namespace {

namespace bounds = box_bounds;

/// A number known up to `error`: high + low, high being the sum rounded.
struct Bounded {
  double high = 0;
  double low = 0;
  double error = 0;

  /// -1 or 1 if certain, else 0. Not a number is never certain.
  int certain_sign() const {
    const double margin = error + std::abs(low);
    return high > margin ? 1 : high < -margin ? -1 : 0;
  }
  bool is_zero() const { return high == 0 && low == 0 && error == 0; }
  Bounded operator-() const { return {-high, -low, error}; }
};

/// A compensated sum [Ogita2005] of at most eight numbers and their parts: its error is at most
/// 2^-98 times the sum of magnitudes, and what underflow takes
/// (docs/explanation/exactness-boxes.md).
class Sum {
 public:
  void add(double x) {
    const TwoDouble sum = two_sum(high_, x);
    high_ = sum.high;
    low_ += sum.low;
    magnitude_ += std::abs(x);
  }
  void add_product(double a, double b) {
    if (a == 0 || b == 0) return;
    const TwoDouble product = two_product(a, b);
    add(product.high);
    low_ += product.low;
    if (!(std::abs(product.high) >= kProductMin)) underflow_ += bounds::kSumFloor;
  }
  Sum operator-() const {
    Sum negative = *this;
    negative.high_ = -high_;
    negative.low_ = -low_;
    return negative;
  }
  Bounded value() const {
    const TwoDouble sum = two_sum(high_, low_);
    return {sum.high, sum.low, magnitude_ * bounds::kSumSlack + underflow_};
  }

 private:
  double high_ = 0;
  double low_ = 0;
  double magnitude_ = 0;
  double underflow_ = 0;
};

/// t = value + correction up to error.
struct Quotient {
  double value = 0;
  double correction = 0;
  double error = kInfD;
};

/// One step of division by hand. Precondition: rate is certainly positive.
Quotient divide(const Bounded& n, const Bounded& rate) {
  Quotient q;
  q.value = n.high / rate.high;
  const double rest = std::fma(-q.value, rate.high, n.high);
  q.correction = (rest + (n.low - q.value * rate.low)) / rate.high;
  const double magnitude = std::abs(q.value);
  q.error = bounds::kQuotientSlack * magnitude +
            bounds::kQuotientFactor * (n.error + magnitude * rate.error) / rate.high +
            bounds::kQuotientFloor * (1 + 1 / rate.high);
  // The factor stands for rates that are known to a sixteenth.
  if (!(rate.error <= rate.high * bounds::kRateError)) q.error = kInfD;
  return q;
}

class OrientedSlabs {
 public:
  OrientedSlabs(const Vec3d& origin, const Vec3d& direction, const OrientedBox& box)
      : origin_(origin), direction_(direction), box_(box) {
    for (std::uint8_t k = 0; k < 3; ++k) {
      find_rate(k);
      find_planes(k);
    }
  }

  bool parallel(std::uint8_t k) const { return rate_sign_[k] == 0; }
  bool lower_first(std::uint8_t k) const { return rate_sign_[k] > 0; }
  bool bounded(BoxFace plane) const { return std::isfinite(box_.half[plane.axis]); }
  int depth_sign(BoxFace plane) const { return depth_sign_[plane.axis][plane.upper ? 1 : 0]; }

  int order(BoxFace first, BoxFace second) const {
    const Quotient& a = at(first);
    const Quotient& b = at(second);
    const double gap = a.value - b.value;
    const double fine = a.correction - b.correction;
    const double slack =
        a.error + b.error +
        bounds::kGapSlack * (std::abs(gap) + std::abs(a.correction) + std::abs(b.correction));
    if (gap + fine > slack) return 1;
    if (gap + fine < -slack) return -1;
    return compare(exact_numerator(first) * exact_rate(second.axis),
                   exact_numerator(second) * exact_rate(first.axis));
  }
  int order(BoxFace plane, double limit) const {
    if (std::isinf(limit)) return limit > 0 ? -1 : 1;
    const Quotient& a = at(plane);
    const double gap = a.value - limit;
    const double slack = a.error + bounds::kGapSlack * (std::abs(gap) + std::abs(a.correction));
    if (gap + a.correction > slack) return 1;
    if (gap + a.correction < -slack) return -1;
    return compare(exact_numerator(plane), Dyadic(limit) * exact_rate(plane.axis));
  }

  double rounded(BoxFace plane) const {
    const Quotient& q = at(plane);
    const double magnitude = std::abs(q.value);
    if (magnitude > 0x1p-900 && magnitude < 0x1p1000) {
      const double t = q.value + q.correction;
      const double lost = (q.value - t) + q.correction;
      const double slack = q.error * (1 + 0x1p-40) + std::abs(lost) * 0x1p-52;
      if (t + (lost - slack) == t && t + (lost + slack) == t) return t;
    }
    return round_quotient(exact_numerator(plane), exact_rate(plane.axis)) + 0.0;  // never -0
  }

 private:
  const Quotient& at(BoxFace plane) const { return quotient_[plane.axis][plane.upper ? 1 : 0]; }
  /// Whether the line crosses this plane on its way in.
  bool entered(BoxFace plane) const { return plane.upper != lower_first(plane.axis); }

  void find_rate(std::uint8_t k) {
    const Vec3d& a = box_.axes[k];
    Sum sum;
    for (int i = 0; i < 3; ++i) sum.add_product(a[i], direction_[i]);
    rate_[k] = sum.value();
    rate_sign_[k] = rate_[k].certain_sign();
    if (rate_sign_[k] == 0 && !rate_[k].is_zero()) rate_sign_[k] = exact_dot(a, direction_).sign();
    if (rate_sign_[k] < 0) rate_[k] = -rate_[k];
  }

  void find_planes(std::uint8_t k) {
    if (!std::isfinite(box_.half[k])) {
      depth_sign_[k] = {1, 1};
      return;
    }
    Sum s;
    for (int i = 0; i < 3; ++i) {
      const TwoDouble from = two_difference(origin_[i], box_.center[i]);
      s.add_product(box_.axes[k][i], from.high);
      s.add_product(box_.axes[k][i], from.low);
    }
    for (const bool upper : {false, true}) {
      const BoxFace plane{k, upper};
      Sum sum = upper ? -s : s;
      sum.add(box_.half[k]);
      const Bounded depth = sum.value();
      int& sign = depth_sign_[k][upper ? 1 : 0];
      sign = depth.certain_sign();
      if (sign == 0 && !depth.is_zero()) sign = exact_depth(plane).sign();
      if (rate_[k].certain_sign() <= 0) continue;
      quotient_[k][upper ? 1 : 0] = divide(entered(plane) ? -depth : depth, rate_[k]);
    }
  }

  Dyadic exact_depth(BoxFace plane) const {
    Dyadic s;
    for (int i = 0; i < 3; ++i) {
      s = s + Dyadic(box_.axes[plane.axis][i]) * (Dyadic(origin_[i]) - Dyadic(box_.center[i]));
    }
    const Dyadic half(box_.half[plane.axis]);
    return plane.upper ? half - s : half + s;
  }
  Dyadic exact_numerator(BoxFace plane) const {
    return entered(plane) ? -exact_depth(plane) : exact_depth(plane);
  }
  Dyadic exact_rate(std::uint8_t k) const { return exact_dot(box_.axes[k], direction_).abs(); }

  const Vec3d& origin_;
  const Vec3d& direction_;
  const OrientedBox& box_;
  std::array<Bounded, 3> rate_;  ///< |R|
  std::array<int, 3> rate_sign_{};
  std::array<std::array<int, 2>, 3> depth_sign_{};
  std::array<std::array<Quotient, 2>, 3> quotient_;
};

}  // namespace

RayBoxAnswer ray_box(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
                     const OrientedBox& box) {
  const OrientedSlabs slabs(origin, direction, box);
  return ray_box_detail::Decision<OrientedSlabs>(slabs, tmin, tmax).answer();
}

PlaneTs ray_box_planes(const Vec3d& origin, const Vec3d& direction, const OrientedBox& box) {
  return ray_box_detail::planes_of(OrientedSlabs(origin, direction, box));
}

Vec3d face_normal(const OrientedBox& box, BoxFace face) {
  return unit_axis(box.axes[face.axis], !face.upper);
}

}  // namespace sightline
