#include "core/geometry/box_sweep.h"

#include <array>

#include "core/geometry/clip_triangle.h"
#include "core/geometry/dyadic_vector.h"

namespace sightline {

namespace {

/// While both share something along all axes that were looked at.
struct Meeting {
  bool has_limits = false;
  ExactT enter, leave;

  /// low <= t * rate <= high. Returns whether anything is left.
  bool narrow(const Dyadic& low, const Dyadic& high, const Dyadic& rate) {
    if (rate.sign() == 0) return low.sign() <= 0 && high.sign() >= 0;
    const bool forward = rate.sign() > 0;
    const ExactT first = forward ? ExactT{low, rate} : ExactT{-high, -rate};
    const ExactT last = forward ? ExactT{high, rate} : ExactT{-low, -rate};
    if (!has_limits || compare(first, enter) > 0) enter = first;
    if (!has_limits || compare(last, leave) < 0) leave = last;
    has_limits = true;
    return compare(enter, leave) <= 0;
  }
};

/// Box and triangle, seen from the origin of the way.
struct Swept {
  std::array<DyadicVector, 3> corner;
  DyadicVector half, direction;

  bool narrow(const DyadicVector& axis, Meeting& meeting) const {
    Dyadic low = dot(axis, corner[0]), high = low;
    for (std::size_t i = 1; i < 3; ++i) {
      const Dyadic at = dot(axis, corner[i]);
      if (at < low) low = at;
      if (high < at) high = at;
    }
    const Dyadic reach =
        half[0] * axis[0].abs() + half[1] * axis[1].abs() + half[2] * axis[2].abs();
    return meeting.narrow(low - reach, high + reach, dot(axis, direction));
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
  const Swept swept{{difference(triangle.v0, path.origin), difference(triangle.v1, path.origin),
                     difference(triangle.v2, path.origin)},
                    exact_vector(box.half),
                    exact_vector(path.direction)};
  const Dyadic one(1.0);
  Meeting meeting;
  for (std::size_t k = 0; k < 3; ++k) {
    DyadicVector axis;
    axis[k] = one;
    if (!swept.narrow(axis, meeting)) return std::nullopt;
  }
  const std::array<DyadicVector, 3> edge{difference(triangle.v1, triangle.v0),
                                         difference(triangle.v2, triangle.v1),
                                         difference(triangle.v0, triangle.v2)};
  if (!swept.narrow(cross(edge[0], edge[1]), meeting)) return std::nullopt;
  for (const DyadicVector& e : edge) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      DyadicVector axis;
      axis[i] = -e[j];
      axis[j] = e[i];
      if (!swept.narrow(axis, meeting)) return std::nullopt;
    }
  }
  if (compare(meeting.enter, path.tmax) > 0 || compare(meeting.leave, path.tmin) < 0) {
    return std::nullopt;
  }
  BoxContact contact;
  contact.t_ = compare(meeting.enter, path.tmin) >= 0 ? meeting.enter
                                                      : ExactT{Dyadic(path.tmin), Dyadic(1.0)};
  return contact;
}

Vec3d BoxContact::position(const SweepPath& path, const SweptBox& box,
                           const Triangle& triangle) const {
  const std::array<const Vec3d*, 3> corner{&triangle.v0, &triangle.v1, &triangle.v2};
  ClippedTriangle shared;
  for (int k = 0; k < 3; ++k) {
    const Dyadic moved = t_.numerator * Dyadic(path.direction[k]);
    DyadicVector above, below;
    for (std::size_t i = 0; i < 3; ++i) {
      const Dyadic from = Dyadic((*corner[i])[k]) - Dyadic(path.origin[k]);
      above[i] = t_.denominator * (from - Dyadic(box.half[k])) - moved;
      below[i] = moved - t_.denominator * (from + Dyadic(box.half[k]));
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

}  // namespace sightline
