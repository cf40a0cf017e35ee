#include "core/import/unhittable.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/exact_hit.h"

namespace sightline::gltf {

namespace {

bool is_finite(const Vec3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

Vec3d widened(const Vec3f& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

/// a * b - c * d is surely not zero. Each factor is a rounded difference of two float32: with
/// u = 2^-53 a product is off by less than 3.01 u of itself and the difference of two adds u, so
/// the result is off by less than 4.1 u (|a b| + |c d|). Nothing underflows: factors are 0 or at
/// least 2^-149.
bool surely_differ(double a, double b, double c, double d) {
  const double first = a * b, second = c * d;
  return std::fabs(first - second) > 0x1p-50 * (std::fabs(first) + std::fabs(second));
}

/// Precondition: finite corners.
bool has_area(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3d p = widened(a), q = widened(b), r = widened(c);
  const double x1 = q.x - p.x, y1 = q.y - p.y, z1 = q.z - p.z;
  const double x2 = r.x - p.x, y2 = r.y - p.y, z2 = r.z - p.z;
  if (surely_differ(x1, y2, y1, x2) || surely_differ(y1, z2, z1, y2) ||
      surely_differ(z1, x2, x1, z2)) {
    return true;
  }
  // Two corners at one place are most of the rest.
  if (a == b || b == c || c == a) return false;
  return !is_degenerate({p, q, r});
}

}  // namespace

Unhittable count_unhittable(const Mesh& mesh) {
  Unhittable count;
  const bool all_finite = std::all_of(mesh.positions.begin(), mesh.positions.end(), is_finite);
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vec3f& a = mesh.positions[mesh.indices[i]];
    const Vec3f& b = mesh.positions[mesh.indices[i + 1]];
    const Vec3f& c = mesh.positions[mesh.indices[i + 2]];
    if (!all_finite && !(is_finite(a) && is_finite(b) && is_finite(c))) {
      ++count.nonfinite;
    } else if (!has_area(a, b, c)) {
      ++count.degenerate;
    }
  }
  return count;
}

}  // namespace sightline::gltf
