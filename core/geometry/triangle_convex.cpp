#include "core/geometry/triangle_convex.h"

#include <array>
#include <cmath>

#include "core/geometry/clip_triangle.h"
#include "core/geometry/exact_hit.h"

namespace sightline {

namespace {

Dyadic exact_value(const HalfSpace& plane, const Vec3d& p) {
  return Dyadic(plane.normal.x) * Dyadic(p.x) + Dyadic(plane.normal.y) * Dyadic(p.y) +
         Dyadic(plane.normal.z) * Dyadic(p.z) - Dyadic(plane.offset);
}

/// The sign where float64 is certain of it, else 0.
int certain_side(const HalfSpace& plane, const Vec3d& p) {
  const double x = plane.normal.x * p.x, y = plane.normal.y * p.y, z = plane.normal.z * p.z;
  const double value = ((x + y) + z) - plane.offset;
  // Each product is rounded once and passes three sums. Overflow and NaN decide nothing.
  const double error =
      0x1p-50 * (std::fabs(x) + std::fabs(y) + std::fabs(z) + std::fabs(plane.offset)) + 0x1p-1070;
  if (value > error) return 1;
  return value < -error ? -1 : 0;
}

}  // namespace

int side_of(const HalfSpace& plane, const Vec3d& p) {
  const int side = certain_side(plane, p);
  return side != 0 ? side : exact_value(plane, p).sign();
}

bool triangle_meets_box(const Triangle& triangle, const ConvexRegion& region) {
  if (!is_finite(triangle)) return false;
  const std::array<const Vec3d*, 3> corner{&triangle.v0, &triangle.v1, &triangle.v2};
  std::array<bool, 3> inside{true, true, true};
  for (const HalfSpace& plane : region.planes) {
    std::array<int, 3> side;
    for (std::size_t i = 0; i < 3; ++i) {
      side[i] = certain_side(plane, *corner[i]);
      inside[i] = inside[i] && side[i] < 0;
    }
    if (side[0] > 0 && side[1] > 0 && side[2] > 0) return false;
  }
  if (is_degenerate(triangle)) return false;
  if (inside[0] || inside[1] || inside[2]) return true;
  ClippedTriangle clipped;
  for (const HalfSpace& plane : region.planes) {
    if (!clipped.clip({exact_value(plane, triangle.v0), exact_value(plane, triangle.v1),
                       exact_value(plane, triangle.v2)})) {
      return false;
    }
  }
  return true;
}

}  // namespace sightline
