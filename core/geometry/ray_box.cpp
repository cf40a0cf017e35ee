#include "core/geometry/ray_box.h"

#include <cmath>

#include "core/geometry/box_bounds.h"
#include "core/geometry/dyadic.h"
#include "core/geometry/error_free.h"
#include "core/geometry/ray_box_decide.h"

namespace sightline {

namespace {

namespace bounds = box_bounds;

/// A plane of an axis-aligned box seen from a ray: t = (minuend - subtrahend) / rate, rate > 0.
struct Crossing {
  double minuend = 0;
  double subtrahend = 0;
  double rate = 1;
  double high = 0;  ///< the rounded difference
  double low = 0;   ///< what rounding it lost; not a number if it overflowed
};

Dyadic exact_numerator(const Crossing& c) { return Dyadic(c.minuend) - Dyadic(c.subtrahend); }

/// Orders two numbers given as a rounded value and what the rounding lost: rounding is monotone, so
/// the rounded values decide unless they are equal.
int compare_parts(const TwoDouble& a, const TwoDouble& b) {
  return a.high != b.high ? (a.high < b.high ? -1 : 1) : a.low < b.low ? -1 : a.low > b.low ? 1 : 0;
}

/// Whether the two parts of a product are its exact value.
bool is_exact_product(double a, double b, const TwoDouble& product) {
  const double high = std::abs(product.high);
  return (high >= kProductMin && high < kInfD) || a == 0 || b == 0;
}

/// The sign of a.numerator * b.rate - b.numerator * a.rate if 100 bits of it tell, else 0. The
/// exact value is a sum of four products; rounding costs at most 16 u^2 size, and u where gap is
/// not exact.
int compare_products(const Crossing& a, const Crossing& b) {
  const TwoDouble left = two_product(a.high, b.rate);
  const TwoDouble right = two_product(b.high, a.rate);
  const double size = std::abs(left.high) + std::abs(right.high);
  if (!(size > 0x1p-900 && size < 0x1p1000)) return 0;
  const double rest = (left.low - right.low) + (a.low * b.rate - b.low * a.rate);
  const double gap = left.high - right.high;
  const double difference = gap + rest;
  const double slack = size * bounds::kProductsSlack + std::abs(gap) * bounds::kGapSlack;
  return difference > slack ? 1 : difference < -slack ? -1 : 0;
}

/// The sign of t(a) - t(b) where the filter cannot tell.
int compare_exactly(const Crossing& a, const Crossing& b) {
  if (a.low == 0 && b.low == 0) {
    const TwoDouble left = two_product(a.high, b.rate);
    const TwoDouble right = two_product(b.high, a.rate);
    if (is_exact_product(a.high, b.rate, left) && is_exact_product(b.high, a.rate, right)) {
      return compare_parts(left, right);
    }
  } else if (const int sign = compare_products(a, b); sign != 0) {
    return sign;
  }
  return compare(exact_numerator(a) * Dyadic(b.rate), exact_numerator(b) * Dyadic(a.rate));
}

int compare_exactly(const Crossing& a, double limit) {
  const TwoDouble right = two_product(limit, a.rate);
  if (std::isfinite(a.high) && std::isfinite(a.low) && is_exact_product(limit, a.rate, right)) {
    return compare_parts({a.high, a.low}, right);
  }
  return compare(exact_numerator(a), Dyadic(limit) * Dyadic(a.rate));
}

/// filter_t is high / rate, rounded.
double round_crossing(const Crossing& c, double filter_t) {
  // An exact difference: the IEEE quotient is the rounded t. The sum turns -0 into +0.
  if (c.low == 0) return filter_t + 0.0;

  // One step of division by hand; the bounds exclude underflow and overflow.
  const auto moderate = [](double x) { return std::abs(x) > 0x1p-900 && std::abs(x) < 0x1p900; };
  if (moderate(c.high) && moderate(c.rate) && moderate(filter_t)) {
    const double rest = std::fma(-filter_t, c.rate, c.high);
    const double correction = (rest + c.low) / c.rate;
    const double slack = std::abs(correction) * bounds::kRefineSlack + bounds::kRefineFloor;
    const double t = filter_t + correction;
    const double lost = (filter_t - t) + correction;
    if (t + (lost - slack) == t && t + (lost + slack) == t) return t;
  }
  return round_quotient(exact_numerator(c), Dyadic(c.rate)) + 0.0;  // never -0
}

class AlignedSlabs {
 public:
  AlignedSlabs(const Vec3d& origin, const Vec3d& direction, const Box3d& box)
      : origin_(origin), direction_(direction), box_(box) {
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      // Not a number or infinite for a parallel ray, and not used then.
      t_[i][0] = (box.min[k] - origin[k]) / direction[k];
      t_[i][1] = (box.max[k] - origin[k]) / direction[k];
    }
  }

  bool parallel(std::uint8_t k) const { return direction_[k] == 0; }
  bool lower_first(std::uint8_t k) const { return direction_[k] > 0; }
  bool bounded(BoxFace plane) const { return std::isfinite(coordinate(plane)); }
  int depth_sign(BoxFace plane) const {
    const double o = origin_[plane.axis];
    const double p = coordinate(plane);
    return o == p ? 0 : (o > p) == plane.upper ? -1 : 1;
  }
  double rounded(BoxFace plane) const { return round_crossing(crossing(plane), t(plane)); }

  int order(BoxFace a, BoxFace b) const {
    const double gap = t(a) - t(b);
    const double slack =
        (std::abs(t(a)) + std::abs(t(b))) * bounds::kCrossingSlack + bounds::kCrossingFloor;
    // Ordered comparisons: what overflowed or is no number falls through.
    if (gap > slack) return 1;
    if (gap < -slack) return -1;
    return compare_exactly(crossing(a), crossing(b));
  }
  int order(BoxFace plane, double limit) const {
    if (std::isinf(limit)) return limit > 0 ? -1 : 1;
    const double gap = t(plane) - limit;
    const double slack = std::abs(t(plane)) * bounds::kCrossingSlack + bounds::kCrossingFloor;
    if (gap > slack) return 1;
    if (gap < -slack) return -1;
    return compare_exactly(crossing(plane), limit);
  }

 private:
  double t(BoxFace plane) const { return t_[plane.axis][plane.upper ? 1 : 0]; }
  double coordinate(BoxFace plane) const {
    return plane.upper ? box_.max[plane.axis] : box_.min[plane.axis];
  }
  Crossing crossing(BoxFace plane) const {
    const double p = coordinate(plane);
    const double o = origin_[plane.axis];
    const double d = direction_[plane.axis];
    const TwoDouble difference = d > 0 ? two_difference(p, o) : two_difference(o, p);
    return {d > 0 ? p : o, d > 0 ? o : p, std::abs(d), difference.high, difference.low};
  }

  const Vec3d& origin_;
  const Vec3d& direction_;
  const Box3d& box_;
  std::array<std::array<double, 2>, 3> t_;
};

}  // namespace

RayBoxAnswer ray_box(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax,
                     const Box3d& box) {
  const AlignedSlabs slabs(origin, direction, box);
  return ray_box_detail::Decision<AlignedSlabs>(slabs, tmin, tmax).answer();
}

PlaneTs ray_box_planes(const Vec3d& origin, const Vec3d& direction, const Box3d& box) {
  return ray_box_detail::planes_of(AlignedSlabs(origin, direction, box));
}

Vec3d face_normal(const Box3d&, BoxFace face) {
  Vec3d normal;
  normal[face.axis] = face.upper ? 1 : -1;
  return normal;
}

}  // namespace sightline
