#include "core/geometry/triangle_sphere.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/dyadic.h"
#include "core/geometry/exact_hit.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

using Vector = std::array<Dyadic, 3>;

Vector difference(const Vec3d& a, const Vec3d& b) {
  return {Dyadic(a.x) - Dyadic(b.x), Dyadic(a.y) - Dyadic(b.y), Dyadic(a.z) - Dyadic(b.z)};
}

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Dyadic dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

bool exact_meeting(const Triangle& triangle, const Sphere& sphere) {
  const std::array<const Vec3d*, 3> corner{&triangle.v0, &triangle.v1, &triangle.v2};
  const Dyadic square = Dyadic(sphere.radius) * Dyadic(sphere.radius);
  std::array<Vector, 3> v, edge;
  for (std::size_t i = 0; i < 3; ++i) {
    v[i] = difference(*corner[i], sphere.center);
    edge[i] = difference(*corner[(i + 1) % 3], *corner[i]);
    if (compare(dot(v[i], v[i]), square) <= 0) return true;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    // Where the center projects to, in units of the edge: between 0 and its squared length.
    const Dyadic along = -dot(v[i], edge[i]), length = dot(edge[i], edge[i]);
    if (along.sign() <= 0 || compare(along, length) >= 0) continue;
    const Vector side = cross(v[i], edge[i]);
    if (compare(dot(side, side), square * length) <= 0) return true;
  }
  const Vector normal = cross(edge[0], edge[1]);
  for (std::size_t i = 0; i < 3; ++i) {
    // The center, seen from the corner, is -v.
    if (dot(normal, cross(edge[i], v[i])).sign() > 0) return false;
  }
  const Dyadic height = dot(normal, v[0]);
  return compare(height * height, square * dot(normal, normal)) <= 0;
}

}  // namespace

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
  return exact_meeting(triangle, sphere) && !is_degenerate(triangle);
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
