#include "tests/stress/ray_box_truth.h"

#include <cmath>

namespace sightline::stress {

namespace {

using Point = std::array<mpq_class, 3>;

Point point_at(const Ray& ray, const mpq_class& t) {
  Point p;
  for (int k = 0; k < 3; ++k) {
    p[static_cast<std::size_t>(k)] = mpq_class(ray.origin[k]) + t * mpq_class(ray.direction[k]);
  }
  return p;
}

mpq_class dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Comparisons with limits that may be infinite.
bool at_least(const mpq_class& t, double limit) {
  return std::isinf(limit) ? limit < 0 : t >= mpq_class(limit);
}
bool at_most(const mpq_class& t, double limit) {
  return std::isinf(limit) ? limit > 0 : t <= mpq_class(limit);
}

std::array<bool, 6> faces_at(const Point& p, const oracle::ExactBox& box) {
  std::array<bool, 6> on{};
  for (std::size_t k = 0; k < 3; ++k) {
    const oracle::Slab& slab = box.slabs[k];
    const mpq_class at = dot(slab.normal, p);
    on[2 * k] = slab.low && at == *slab.low;
    on[2 * k + 1] = slab.high && at == *slab.high;
  }
  return on;
}

}  // namespace

bool RayBoxTruth::exclude(std::size_t a, std::size_t b) const {
  const oracle::SlabTimes& x = line.slabs[a];
  const oracle::SlabTimes& y = line.slabs[b];
  if (x.never || y.never) return true;
  return (x.enter && y.leave && *x.enter > *y.leave) || (y.enter && x.leave && *y.enter > *x.leave);
}

RayBoxTruth ray_box_truth(const Ray& ray, const oracle::ExactBox& box) {
  RayBoxTruth truth;
  truth.line = oracle::line_times(ray, box);
  const oracle::LineTimes& line = truth.line;
  for (std::size_t k = 0; k < 3; ++k) {
    const oracle::SlabTimes& slab = line.slabs[k];
    if (slab.parallel) continue;
    // The plane that is entered may be missing: then the one that is left tells the way.
    const bool up = slab.enter ? slab.enter_side < 0 : box.slabs[k].high.has_value();
    truth.planes[2 * k] = up ? slab.enter : slab.leave;
    truth.planes[2 * k + 1] = up ? slab.leave : slab.enter;
  }
  if (!line.hit) return truth;
  truth.behind = line.leave && !at_least(*line.leave, ray.tmin);
  truth.beyond = line.enter && !at_most(*line.enter, ray.tmax);
  truth.hit = !truth.behind && !truth.beyond;
  if (!truth.hit) return truth;

  // The rules of RayBoxAnswer::t, one after the other.
  const auto within = [&](const std::optional<mpq_class>& t) {
    return t && at_least(*t, ray.tmin) && at_most(*t, ray.tmax) ? t : std::nullopt;
  };
  if (line.origin_on_surface) truth.t = within(mpq_class(0));
  if (!truth.t && line.origin_inside) truth.t = within(line.leave);
  if (!truth.t) truth.t = within(line.enter);
  if (!truth.t) truth.t = within(line.leave);
  if (truth.t) truth.faces = faces_at(point_at(ray, *truth.t), box);
  return truth;
}

}  // namespace sightline::stress
