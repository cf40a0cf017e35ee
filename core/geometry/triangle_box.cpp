#include "core/geometry/triangle_box.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/box_bounds.h"
#include "core/geometry/exact_hit.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

namespace bounds = box_bounds;

/// A triangle in the coordinates in which the box is axis-aligned, each known up to `delta`.
struct Placed {
  std::array<std::array<double, 3>, 3> corner{};  ///< [corner][axis]
  std::array<double, 3> delta{};
  std::array<double, 3> low{}, high{};  ///< the box
};

/// What is known of one comparison after another. Not a number decides nothing.
class Tally {
 public:
  void apart_if(bool certain) { apart_ = apart_ || certain; }
  void meet_only_if(bool certain) { open_ = open_ || !certain; }
  bool apart() const { return apart_; }
  bool open() const { return open_; }

 private:
  bool apart_ = false;
  bool open_ = false;
};

/// Whether the line of numbers [a_low, a_high] and [b_low, b_high] certainly meet or certainly do
/// not, each end known up to half of `slack`.
void compare_ranges(double a_low, double a_high, double b_low, double b_high, double slack,
                    Tally& tally) {
  tally.apart_if(a_low - b_high > slack || b_low - a_high > slack);
  tally.meet_only_if(b_high - a_low >= slack && a_high - b_low >= slack);
}

struct Range {
  double low, high;
};
/// The values of factor * x for x in the range.
Range times(double factor, const Range& x) {
  const double a = factor * x.low;
  const double b = factor * x.high;
  return a < b ? Range{a, b} : Range{b, a};
}

/// True if corner c is certainly in the box. A rounded x - delta above `low` is above it unrounded
/// too.
bool is_corner_within(const Placed& p, std::size_t c) {
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = p.corner[c][k], delta = p.delta[k];
    const bool within = delta == 0 ? x >= p.low[k] && x <= p.high[k]
                                   : x - delta > p.low[k] && x + delta < p.high[k];
    if (!within) return false;
  }
  return true;
}

OverlapVerdict filter(const Placed& p) {
  const auto& v = p.corner;
  Tally tally;

  // The box's own normals; then cut the box to bounds of the triangle.
  std::array<double, 3> low{}, high{}, extent{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double least = std::min({v[0][k], v[1][k], v[2][k]});
    const double most = std::max({v[0][k], v[1][k], v[2][k]});
    const double delta = p.delta[k];
    if (least - delta > p.high[k] || most + delta < p.low[k]) return OverlapVerdict::kApart;
    tally.meet_only_if(least + delta <= p.high[k] && most - delta >= p.low[k]);
    low[k] = std::max(p.low[k], delta == 0 ? least : next_below(least - delta));
    high[k] = std::min(p.high[k], delta == 0 ? most : next_above(most + delta));
    extent[k] = ((most - least) + 4 * delta) * (1 + 8 * kU);
  }

  // bound[k]: of cross products with axis k. Nothing is rounded where an extent is zero.
  std::array<double, 3> bound{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    bound[k] = extent[i] == 0 || extent[j] == 0
                   ? 0
                   : bounds::kCrossDelta * (extent[i] * p.delta[j] + extent[j] * p.delta[i]) +
                         bounds::kCrossSlack * (extent[i] * extent[j]) + bounds::kCrossFloor;
  }

  std::array<std::array<double, 3>, 3> edge{};
  for (std::size_t e = 0; e < 3; ++e) {
    for (std::size_t k = 0; k < 3; ++k) edge[e][k] = v[(e + 1) % 3][k] - v[e][k];
  }

  // The triangle's normal, which also tells whether it has an area.
  std::array<double, 3> normal{};
  bool has_area = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    normal[k] = edge[0][i] * edge[1][j] - edge[0][j] * edge[1][i];
    has_area = has_area || std::abs(normal[k]) > bound[k];
  }
  // The corner is a point of both. Below, a box that was cut to the triangle touches its corners,
  // which would be left to the exact stage.
  if (has_area && (is_corner_within(p, 0) || is_corner_within(p, 1) || is_corner_within(p, 2)))
    return OverlapVerdict::kMeet;
  if (extent[0] != 0 && extent[1] != 0 && extent[2] != 0) {
    Range reach{0, 0};
    double slack =
        bounds::kNormalSlack * (extent[0] * extent[1]) * extent[2] + bounds::kNormalFloor;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const Range part = times(normal[k], {low[k] - v[0][k], high[k] - v[0][k]});
      reach.low += part.low;
      reach.high += part.high;
      slack += extent[k] * bound[k] + bounds::kNormalDelta * (extent[i] * extent[j] * p.delta[k]);
    }
    compare_ranges(0, 0, reach.low, reach.high, slack * (1 + 32 * kU), tally);
    if (tally.apart()) return OverlapVerdict::kApart;
  }

  // Edges against axes: along cross(axis, edge) the edge is one point, 0, and so is the triangle's
  // range between it and the third corner.
  for (std::size_t e = 0; e < 3; ++e) {
    const auto& a = v[e];
    const auto& c = v[(e + 2) % 3];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const double third = edge[e][i] * (c[j] - a[j]) - edge[e][j] * (c[i] - a[i]);
      const Range plus = times(edge[e][i], {low[j] - a[j], high[j] - a[j]});
      const Range minus = times(edge[e][j], {low[i] - a[i], high[i] - a[i]});
      compare_ranges(std::min(0.0, third), std::max(0.0, third), plus.low - minus.high,
                     plus.high - minus.low, 2.5 * bound[k], tally);
    }
  }
  if (tally.apart()) return OverlapVerdict::kApart;
  return has_area && !tally.open() ? OverlapVerdict::kMeet : OverlapVerdict::kOpen;
}

std::array<double, 3> as_array(const Vec3d& v) { return {v.x, v.y, v.z}; }

}  // namespace

OverlapVerdict filter_triangle_box(const Triangle& triangle, const Box3d& box) {
  Placed p;
  p.corner = {as_array(triangle.v0), as_array(triangle.v1), as_array(triangle.v2)};
  p.low = as_array(box.min);
  p.high = as_array(box.max);
  return filter(p);
}

OverlapVerdict filter_triangle_box(const Triangle& triangle, const OrientedBox& box) {
  Placed p;
  const std::array<const Vec3d*, 3> corners{&triangle.v0, &triangle.v1, &triangle.v2};
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    const Vec3d& a = box.axes[axis];
    double magnitude = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double x = a.x * (corners[c]->x - box.center.x);
      const double y = a.y * (corners[c]->y - box.center.y);
      const double z = a.z * (corners[c]->z - box.center.z);
      p.corner[c][axis] = x + y + z;
      magnitude = std::max(magnitude, std::abs(x) + std::abs(y) + std::abs(z));
    }
    // Four roundings of each term, and what underflow takes.
    p.delta[axis] = magnitude * bounds::kPlacedSlack + bounds::kPlacedFloor;
    p.low[axis] = -box.half[k];
    p.high[axis] = box.half[k];
  }
  return filter(p);
}

bool triangle_meets_box(const Triangle& triangle, const Box3d& box) {
  if (!is_finite(triangle)) return false;
  const OverlapVerdict verdict = filter_triangle_box(triangle, box);
  return verdict == OverlapVerdict::kOpen ? exact_triangle_box(triangle, box)
                                          : verdict == OverlapVerdict::kMeet;
}

bool triangle_meets_box(const Triangle& triangle, const OrientedBox& box) {
  if (!is_finite(triangle)) return false;
  const OverlapVerdict verdict = filter_triangle_box(triangle, box);
  return verdict == OverlapVerdict::kOpen ? exact_triangle_box(triangle, box)
                                          : verdict == OverlapVerdict::kMeet;
}

}  // namespace sightline
