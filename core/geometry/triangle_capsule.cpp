#include "core/geometry/triangle_capsule.h"

#include <algorithm>
#include <array>

#include "core/geometry/exact_hit.h"
#include "core/geometry/rounding.h"
#include "core/geometry/triangle_distance.h"

namespace sightline {

bool triangle_meets_box(const Triangle& triangle, const Capsule& capsule) {
  if (!is_finite(triangle)) return false;
  const std::array<Vec3d, 2> axis{capsule.from, capsule.to};
  const DistanceRange range = distance_range(axis, corners_of(triangle));
  if (range.low > capsule.radius || is_degenerate(triangle)) return false;
  return range.high <= capsule.radius ||
         compare(exact_distance(axis, triangle), capsule.radius) <= 0;
}

Box3d outer_bounds(const Capsule& capsule) {
  Box3d box;
  for (int k = 0; k < 3; ++k) {
    box.min[k] = next_below(std::min(capsule.from[k], capsule.to[k]) - capsule.radius);
    box.max[k] = next_above(std::max(capsule.from[k], capsule.to[k]) + capsule.radius);
  }
  return box;
}

}  // namespace sightline
