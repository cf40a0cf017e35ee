#include "core/geometry/triangle_sphere.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/exact_hit.h"
#include "core/geometry/point_triangle.h"
#include "core/geometry/rounding.h"

namespace sightline {

bool triangle_meets_box(const Triangle& triangle, const Sphere& sphere) {
  if (!is_finite(triangle)) return false;
  const std::array<const Vec3d*, 3> corner{&triangle.v0, &triangle.v1, &triangle.v2};
  // Beside it on an axis: differences of float64 numbers are zero only if they are, and otherwise
  // within 2^-53 of themselves.
  constexpr double kMore = 1 + 0x1p-50;
  for (int k = 0; k < 3; ++k) {
    const double low = std::min({triangle.v0[k], triangle.v1[k], triangle.v2[k]});
    const double high = std::max({triangle.v0[k], triangle.v1[k], triangle.v2[k]});
    if (low - sphere.center[k] > sphere.radius * kMore + 0x1p-1060) return false;
    if (sphere.center[k] - high > sphere.radius * kMore + 0x1p-1060) return false;
  }
  // A corner that is certainly inside. Where squares could vanish the radius is too small for this.
  const double inside = sphere.radius * sphere.radius * (1 - 0x1p-48);
  for (const Vec3d* v : corner) {
    const double x = v->x - sphere.center.x, y = v->y - sphere.center.y, z = v->z - sphere.center.z;
    if (inside > 0x1p-900 && x * x + y * y + z * z < inside) return !is_degenerate(triangle);
  }
  return !is_degenerate(triangle) &&
         compare(exact_distance(sphere.center, triangle), sphere.radius) <= 0;
}

Box3d outer_bounds(const Sphere& sphere) {
  Box3d box;
  for (int k = 0; k < 3; ++k) {
    box.min[k] = next_below(sphere.center[k] - sphere.radius);
    box.max[k] = next_above(sphere.center[k] + sphere.radius);
  }
  return box;
}

}  // namespace sightline
