#include "core/geometry/triangle_within.h"

#include <cmath>

#include "core/geometry/box_bounds.h"
#include "core/geometry/dyadic_vector.h"

namespace sightline {

namespace {

/// |axis . (p - center)| <= half
bool is_between(const Vec3d& p, const Vec3d& center, const Vec3d& axis, double half) {
  const double x = axis.x * (p.x - center.x), y = axis.y * (p.y - center.y),
               z = axis.z * (p.z - center.z);
  const double sum = std::fabs((x + y) + z);
  // As of the corners of a triangle (docs/explanation/exactness-boxes.md).
  const double error = box_bounds::kPlacedSlack * (std::fabs(x) + std::fabs(y) + std::fabs(z)) +
                       box_bounds::kPlacedFloor;
  if (sum + error < half) return true;
  if (sum - error > half) return false;
  if (std::isinf(half)) return true;
  return compare(dot(exact_vector(axis), difference(p, center)).abs(), Dyadic(half)) <= 0;
}

}  // namespace

bool is_within(const Vec3d& p, const Box3d& box) {
  for (int k = 0; k < 3; ++k) {
    if (p[k] < box.min[k] || p[k] > box.max[k]) return false;
  }
  return true;
}

bool is_within(const Vec3d& p, const OrientedBox& box) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (!is_between(p, box.center, box.axes[k], box.half[static_cast<int>(k)])) return false;
  }
  return true;
}

bool is_within(const Vec3d& p, const Sphere& sphere) {
  return is_within(p, Capsule{sphere.center, sphere.center, sphere.radius});
}

bool is_within(const Vec3d& p, const Capsule& capsule) {
  const auto& [from, to, radius] = capsule;
  const double square = radius * radius;
  const auto square_to = [&](const Vec3d& end) {
    const double x = p.x - end.x, y = p.y - end.y, z = p.z - end.z;
    return x * x + y * y + z * z;
  };
  // Squares lose no more than 2^-50 of themselves, and below 2^-900 nothing is certain.
  if (square > 0x1p-900 &&
      (square_to(from) < square * (1 - 0x1p-48) || square_to(to) < square * (1 - 0x1p-48))) {
    return true;
  }
  for (int k = 0; k < 3; ++k) {
    const double low = std::fmin(from[k], to[k]), high = std::fmax(from[k], to[k]);
    // A difference is within 2^-53 of itself.
    const double most = radius * (1 + 0x1p-50) + 0x1p-1060;
    if (low - p[k] > most || p[k] - high > most) return false;
  }
  const DyadicVector d = difference(to, from), w = difference(p, from);
  const Dyadic along = dot(w, d), length = dot(d, d), exact_radius(radius);
  const Dyadic exact_square = exact_radius * exact_radius;
  if (along.sign() <= 0) return compare(dot(w, w), exact_square) <= 0;
  if (compare(along, length) >= 0) {
    const DyadicVector v = difference(p, to);
    return compare(dot(v, v), exact_square) <= 0;
  }
  const DyadicVector side = cross(w, d);
  return compare(dot(side, side), exact_square * length) <= 0;
}

bool is_within(const Vec3d& p, const ConvexRegion& region) {
  for (const HalfSpace& plane : region.planes) {
    if (side_of(plane, p) > 0) return false;
  }
  return true;
}

}  // namespace sightline
