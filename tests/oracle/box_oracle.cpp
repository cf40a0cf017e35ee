#include "tests/oracle/box_oracle.h"

#include <cmath>
#include <vector>

namespace sightline::oracle {
namespace {

using Point = std::array<mpq_class, 3>;

Point rational(const Vec3d& v) { return {mpq_class(v.x), mpq_class(v.y), mpq_class(v.z)}; }
mpq_class dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Slab around(const Point& normal, const Point& center, const std::optional<mpq_class>& reach) {
  Slab slab{normal, {}, {}};
  if (reach) {
    const mpq_class middle = dot(normal, center);
    slab.low = middle - *reach;
    slab.high = middle + *reach;
  }
  return slab;
}

/// The part of a convex polygon with normal . p <= bound; may shrink to a segment or a point.
std::vector<Point> clip(const std::vector<Point>& polygon, const Point& normal,
                        const mpq_class& bound) {
  std::vector<Point> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& a = polygon[i];
    const Point& b = polygon[(i + 1) % polygon.size()];
    const mpq_class beyond_a = dot(normal, a) - bound;
    const mpq_class beyond_b = dot(normal, b) - bound;
    if (beyond_a <= 0) kept.push_back(a);
    if (sgn(beyond_a) * sgn(beyond_b) < 0) {
      const mpq_class s = beyond_a / (beyond_a - beyond_b);
      kept.push_back(
          {a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])});
    }
  }
  return kept;
}

Point negated(const Point& p) { return {-p[0], -p[1], -p[2]}; }

}  // namespace

ExactBox axis_aligned(const Box3d& box) {
  ExactBox result;
  for (int k = 0; k < 3; ++k) {
    Slab& slab = result.slabs[static_cast<std::size_t>(k)];
    slab.normal[static_cast<std::size_t>(k)] = 1;
    if (std::isfinite(box.min[k])) slab.low = mpq_class(box.min[k]);
    if (std::isfinite(box.max[k])) slab.high = mpq_class(box.max[k]);
  }
  return result;
}

ExactBox oriented_by_slabs(const Vec3d& center, const std::array<Vec3d, 3>& axes,
                           const Vec3d& half) {
  ExactBox result;
  for (std::size_t k = 0; k < 3; ++k) {
    const double reach = half[static_cast<int>(k)];
    result.slabs[k] = around(rational(axes[k]), rational(center),
                             std::isfinite(reach) ? std::optional(mpq_class(reach)) : std::nullopt);
  }
  return result;
}

ExactBox oriented_by_edges(const Vec3d& center, const std::array<Vec3d, 3>& axes,
                           const Vec3d& half) {
  // a_k = n_k . (p - c) / det with n_k the cross product of the other two axes.
  ExactBox result;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point normal = cross(rational(axes[(k + 1) % 3]), rational(axes[(k + 2) % 3]));
    const mpq_class det = abs(dot(normal, rational(axes[k])));
    const double reach = half[static_cast<int>(k)];
    std::optional<mpq_class> scaled;
    if (std::isfinite(reach)) scaled = mpq_class(reach) * det;
    result.slabs[k] = around(normal, rational(center), scaled);
  }
  return result;
}

LineTimes line_times(const Ray& ray, const ExactBox& box) {
  const Point origin = rational(ray.origin);
  const Point direction = rational(ray.direction);
  LineTimes result;
  result.hit = true;
  bool within = true;
  bool on_plane = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Slab& slab = box.slabs[k];
    SlabTimes& times = result.slabs[k];
    const mpq_class at = dot(slab.normal, origin);
    const mpq_class slope = dot(slab.normal, direction);
    const bool below = slab.low && at < *slab.low;
    const bool above = slab.high && at > *slab.high;
    within = within && !below && !above;
    on_plane = on_plane || (slab.low && at == *slab.low) || (slab.high && at == *slab.high);
    if (sgn(slope) == 0) {
      times.parallel = true;
      times.never = below || above;
      result.hit = result.hit && !times.never;
      continue;
    }
    const bool up = sgn(slope) > 0;
    const auto& first = up ? slab.low : slab.high;
    const auto& last = up ? slab.high : slab.low;
    if (first) {
      times.enter = (*first - at) / slope;
      times.enter_side = up ? -1 : 1;
      if (!result.enter || *times.enter > *result.enter) result.enter = times.enter;
    }
    if (last) {
      times.leave = (*last - at) / slope;
      if (!result.leave || *times.leave < *result.leave) result.leave = times.leave;
    }
  }
  if (result.enter && result.leave && *result.enter > *result.leave) result.hit = false;
  result.origin_on_surface = within && on_plane;
  result.origin_inside = within && !on_plane;
  return result;
}

bool overlap(const ExactBox& box, const Triangle& triangle) {
  std::vector<Point> polygon{rational(triangle.v0), rational(triangle.v1), rational(triangle.v2)};
  for (const Slab& slab : box.slabs) {
    if (slab.high) polygon = clip(polygon, slab.normal, *slab.high);
    if (slab.low) polygon = clip(polygon, negated(slab.normal), -*slab.low);
    if (polygon.empty()) return false;
  }
  return true;
}

}  // namespace sightline::oracle
