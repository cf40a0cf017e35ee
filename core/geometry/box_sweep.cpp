#include "core/geometry/box_sweep.h"

#include <array>

#include "core/geometry/clip_triangle.h"
#include "core/geometry/dyadic_vector.h"

namespace sightline {

namespace {

/// While both share something along all axes that were tested.
struct Meeting {
  bool has_limits = false;
  ExactT enter, leave;
  std::size_t met_last = 0;  ///< the first of the axes along which they meet last

  /// low <= t * rate <= high on an axis. Returns whether anything is left.
  bool narrow(std::size_t axis, const Dyadic& low, const Dyadic& high, const Dyadic& rate) {
    if (rate.sign() == 0) return low.sign() <= 0 && high.sign() >= 0;
    const bool forward = rate.sign() > 0;
    const ExactT first(forward ? low : high, rate), last(forward ? high : low, rate);
    if (!has_limits || compare(first, enter) > 0) {
      enter = first;
      met_last = axis;
    }
    if (!has_limits || compare(last, leave) < 0) leave = last;
    has_limits = true;
    return compare(enter, leave) <= 0;
  }
};

/// Components along the axes of the box.
DyadicVector in_box(const SweptBox& box, const DyadicVector& v) {
  if (!box.axes) return v;
  const auto& a = *box.axes;
  return {dot(exact_vector(a[0]), v), dot(exact_vector(a[1]), v), dot(exact_vector(a[2]), v)};
}

/// Box and triangle, seen from the origin of the way, in the box's coordinates.
struct Swept {
  std::array<DyadicVector, 3> corner, edge;
  DyadicVector half, direction;

  Swept(const SweepPath& path, const SweptBox& box, const Triangle& t)
      : corner{in_box(box, difference(t.v0, path.origin)),
               in_box(box, difference(t.v1, path.origin)),
               in_box(box, difference(t.v2, path.origin))},
        edge{in_box(box, difference(t.v1, t.v0)), in_box(box, difference(t.v2, t.v1)),
             in_box(box, difference(t.v0, t.v2))},
        half(exact_vector(box.half)),
        direction(in_box(box, exact_vector(path.direction))) {}

  /// Separating axis 0 to 12: the normals of the box, that of the triangle, the cross products.
  DyadicVector axis(std::size_t number) const {
    if (number == 3) return cross(edge[0], edge[1]);
    DyadicVector axis;
    if (number < 3) {
      axis[number] = Dyadic(1.0);
      return axis;
    }
    const DyadicVector& e = edge[(number - 4) / 3];
    const std::size_t k = (number - 4) % 3, i = (k + 1) % 3, j = (k + 2) % 3;
    axis[i] = -e[j];
    axis[j] = e[i];
    return axis;
  }

  bool narrow(std::size_t number, Meeting& meeting) const {
    const DyadicVector along = axis(number);
    Dyadic low = dot(along, corner[0]), high = low;
    for (std::size_t i = 1; i < 3; ++i) {
      const Dyadic at = dot(along, corner[i]);
      if (at < low) low = at;
      if (high < at) high = at;
    }
    const Dyadic reach =
        half[0] * along[0].abs() + half[1] * along[1].abs() + half[2] * along[2].abs();
    return meeting.narrow(number, low - reach, high + reach, dot(along, direction));
  }
};

/// a / b as a point in space, over one divisor.
struct ExactPoint {
  DyadicVector at;
  Dyadic divisor;
};

bool is_less(const ExactPoint& a, const ExactPoint& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    const int order = compare(a.at[k] * b.divisor, b.at[k] * a.divisor);
    if (order != 0) return order < 0;
  }
  return false;
}

}  // namespace

std::optional<BoxContact> BoxContact::first(const SweepPath& path, const SweptBox& box,
                                            const Triangle& triangle) {
  if (!is_finite(triangle) || is_degenerate(triangle)) return std::nullopt;
  const Swept swept(path, box, triangle);
  Meeting meeting;
  for (std::size_t i = 0; i < kNoAxis; ++i)
    if (!swept.narrow(i, meeting)) return std::nullopt;
  if (compare(meeting.enter, path.tmax) > 0 || compare(meeting.leave, path.tmin) < 0) {
    return std::nullopt;
  }
  BoxContact contact;
  const bool begins = compare(meeting.enter, path.tmin) < 0;
  contact.t_ = begins ? ExactT(Dyadic(path.tmin), Dyadic(1.0)) : meeting.enter;
  contact.axis_ = begins ? kNoAxis : meeting.met_last;
  return contact;
}

Vec3d BoxContact::position(const SweepPath& path, const SweptBox& box,
                           const Triangle& triangle) const {
  const Swept swept(path, box, triangle);
  const Dyadic numerator = t_.numerator(), denominator = t_.denominator();
  ClippedTriangle shared;
  for (std::size_t k = 0; k < 3; ++k) {
    const Dyadic moved = numerator * swept.direction[k];
    DyadicVector above, below;
    for (std::size_t i = 0; i < 3; ++i) {
      const Dyadic& from = swept.corner[i][k];
      above[i] = denominator * (from - swept.half[k]) - moved;
      below[i] = moved - denominator * (from + swept.half[k]);
    }
    shared.clip(above);
    shared.clip(below);
  }
  ExactPoint least;
  for (std::size_t i = 0; i < shared.size(); ++i) {
    const DyadicVector& weight = shared.weights(i);
    ExactPoint point{{}, weight[0] + weight[1] + weight[2]};
    for (int k = 0; k < 3; ++k) {
      point.at[static_cast<std::size_t>(k)] = weight[0] * Dyadic(triangle.v0[k]) +
                                              weight[1] * Dyadic(triangle.v1[k]) +
                                              weight[2] * Dyadic(triangle.v2[k]);
    }
    if (i == 0 || is_less(point, least)) least = point;
  }
  return {round_quotient(least.at[0], least.divisor), round_quotient(least.at[1], least.divisor),
          round_quotient(least.at[2], least.divisor)};
}

std::optional<Vec3d> BoxContact::normal(const SweepPath& path, const SweptBox& box,
                                        const Triangle& triangle) const {
  if (axis_ == kNoAxis) return std::nullopt;
  const Swept swept(path, box, triangle);
  const DyadicVector axis = swept.axis(axis_);
  DyadicVector n = axis;
  if (box.axes) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int i = static_cast<int>(k);
      const auto& a = *box.axes;
      n[k] = axis[0] * Dyadic(a[0][i]) + axis[1] * Dyadic(a[1][i]) + axis[2] * Dyadic(a[2][i]);
    }
  }
  // The box moves against it.
  const bool is_along = dot(axis, swept.direction).sign() > 0;
  const Dyadic square = dot(n, n);
  Vec3d normal;
  for (int k = 0; k < 3; ++k) {
    const Dyadic& along = n[static_cast<std::size_t>(k)];
    normal[k] = round_over_root(is_along ? -along : along, square);
  }
  return normal;
}

}  // namespace sightline
