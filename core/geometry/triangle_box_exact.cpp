/// The last stage of triangle against box: the same separating axes in Dyadic numbers.

#include <array>
#include <cmath>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/exact_hit.h"
#include "core/geometry/triangle_box.h"

namespace sightline {

namespace {

struct ExactPlaced {
  std::array<DyadicVector, 3> corner;
  DyadicVector low, high;
};

const Dyadic& least(const Dyadic& a, const Dyadic& b) { return b < a ? b : a; }
const Dyadic& most(const Dyadic& a, const Dyadic& b) { return a < b ? b : a; }

/// Sets a side of the box; an open one goes to the triangle's own bound, which cuts nothing off.
void set_side(double value, std::size_t k, bool upper, const Dyadic& offset, ExactPlaced& p) {
  Dyadic& side = upper ? p.high[k] : p.low[k];
  if (std::isfinite(value)) {
    side = Dyadic(value) + offset;
  } else if (upper) {
    side = most(most(p.corner[0][k], p.corner[1][k]), p.corner[2][k]);
  } else {
    side = least(least(p.corner[0][k], p.corner[1][k]), p.corner[2][k]);
  }
}

/// The least and the greatest value of x over the box and over the triangle, as signs: whether the
/// box lies strictly on one side of the triangle along the axis with components `along`.
bool separates(const ExactPlaced& p, const DyadicVector& along) {
  Dyadic box_low, box_high;
  std::array<Dyadic, 3> at;
  for (std::size_t k = 0; k < 3; ++k) {
    const int sign = along[k].sign();
    if (sign == 0) continue;
    box_low = box_low + along[k] * (sign > 0 ? p.low[k] : p.high[k]);
    box_high = box_high + along[k] * (sign > 0 ? p.high[k] : p.low[k]);
    for (std::size_t c = 0; c < 3; ++c) at[c] = at[c] + along[k] * p.corner[c][k];
  }
  const bool above = box_high < at[0] && box_high < at[1] && box_high < at[2];
  const bool below = at[0] < box_low && at[1] < box_low && at[2] < box_low;
  return above || below;
}

bool meet(const ExactPlaced& p) {
  const Dyadic one(1.0);
  for (std::size_t k = 0; k < 3; ++k) {
    DyadicVector along;
    along[k] = one;
    if (separates(p, along)) return false;
  }
  std::array<DyadicVector, 3> edge;
  for (std::size_t e = 0; e < 3; ++e) {
    for (std::size_t k = 0; k < 3; ++k) edge[e][k] = p.corner[(e + 1) % 3][k] - p.corner[e][k];
  }
  const DyadicVector normal = cross(edge[0], edge[1]);
  if (separates(p, normal)) return false;
  for (std::size_t e = 0; e < 3; ++e) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      DyadicVector along;
      along[i] = -edge[e][j];
      along[j] = edge[e][i];
      if (separates(p, along)) return false;
    }
  }
  return true;
}

}  // namespace

bool exact_triangle_box(const Triangle& triangle, const Box3d& box) {
  if (is_degenerate(triangle)) return false;
  ExactPlaced p;
  const std::array<const Vec3d*, 3> corners{&triangle.v0, &triangle.v1, &triangle.v2};
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    for (std::size_t c = 0; c < 3; ++c) p.corner[c][axis] = Dyadic((*corners[c])[k]);
    set_side(box.min[k], axis, false, Dyadic(), p);
    set_side(box.max[k], axis, true, Dyadic(), p);
  }
  return meet(p);
}

bool exact_triangle_box(const Triangle& triangle, const OrientedBox& box) {
  if (is_degenerate(triangle)) return false;
  ExactPlaced p;
  const std::array<const Vec3d*, 3> corners{&triangle.v0, &triangle.v1, &triangle.v2};
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    const Vec3d& a = box.axes[axis];
    for (std::size_t c = 0; c < 3; ++c) p.corner[c][axis] = exact_dot(a, *corners[c]);
    const Dyadic middle = exact_dot(a, box.center);
    set_side(-box.half[k], axis, false, middle, p);
    set_side(box.half[k], axis, true, middle, p);
  }
  return meet(p);
}

}  // namespace sightline
