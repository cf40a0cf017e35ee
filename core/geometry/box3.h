#pragma once
/// Box3d: a closed axis-aligned box of float64 coordinates. By default it is empty: min = +inf and
/// max = -inf. include() extends it.

#include <algorithm>
#include <limits>

#include "core/geometry/vec3.h"

namespace sightline {

/// The points p with min <= p <= max on every axis. A bound may be infinite: the box is then open
/// on that side.
struct Box3d {
  static constexpr double kInf = std::numeric_limits<double>::infinity();
  Vec3d min{kInf, kInf, kInf};
  Vec3d max{-kInf, -kInf, -kInf};

  /// True if the box contains no point: min > max on an axis, or a bound is NaN.
  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  /// Extends the box to contain a point. NaN coordinates are ignored.
  void include(const Vec3d& p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  /// Extends the box to contain another box; an empty box changes nothing.
  void include(const Box3d& other) {
    if (other.empty()) return;
    include(other.min);
    include(other.max);
  }
  bool operator==(const Box3d&) const = default;
};

}  // namespace sightline

// Tests: tests/unit/geometry/ray_box_test.cpp
