#include "tests/stress/aims.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/oracle/narrow.h"
#include "tests/stress/meshes.h"

namespace sightline::stress {

Vec3d plus(const Vec3d& a, double s, const Vec3d& b) {
  return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
Vec3d minus(const Vec3d& a, const Vec3d& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(const Vec3d& v) { return std::hypot(v.x, v.y, v.z); }
Vec3d scaled(const Vec3d& v, double s) { return {s * v.x, s * v.y, s * v.z}; }
Vec3d as_float32(const Vec3d& v) {
  return {oracle::to_float32(v.x), oracle::to_float32(v.y), oracle::to_float32(v.z)};
}

Vec3d point_of(const Triangle& w, double a, double b) {
  return plus(plus(w.v0, a, minus(w.v1, w.v0)), b, minus(w.v2, w.v0));
}
std::array<Vec3d, 3> corners(const Triangle& w) { return {w.v0, w.v1, w.v2}; }

Aim::Aim(const SceneDescription& scene, Random& random) : random_(random) {
  for (const Triangle& w : world(scene)) {
    if (!oracle::is_finite(w)) continue;
    triangles_.push_back(w);
    for (const Vec3d& v : corners(w)) box_.include(v);
  }
  for (int k = 0; k < 3; ++k) middle_[k] = 0.5 * box_.min[k] + 0.5 * box_.max[k];
  size_ = std::max({box_.max.x - box_.min.x, box_.max.y - box_.min.y, box_.max.z - box_.min.z,
                    std::numeric_limits<double>::denorm_min()});
  size_ = std::min(size_, std::numeric_limits<double>::max());
  quantum_ = std::exp2(std::floor(std::log2(size_)) - 6);
}

const Triangle& Aim::triangle() const { return triangles_[random_.index(triangles_.size())]; }

Vec3d Aim::corner() const { return corners(triangle())[random_.index(3)]; }

Vec3d Aim::edge_point() const {
  const auto v = corners(triangle());
  const std::size_t i = random_.index(3);
  const double s = random_.chance(0.7) ? 0.125 * random_.integer(1, 7) : random_.unit();
  return plus(v[i], s, minus(v[(i + 1) % 3], v[i]));
}

Vec3d Aim::inner_point() const {
  const bool dyadic = random_.chance(0.5);
  const double a = dyadic ? 0.125 * random_.integer(1, 4) : 0.5 * random_.unit();
  const double b = dyadic ? 0.125 * random_.integer(1, 3) : 0.5 * random_.unit();
  return point_of(triangle(), a, b);
}

Vec3d Aim::around(double margin) const {
  Vec3d p;
  for (int k = 0; k < 3; ++k)
    p[k] = random_.between(box_.min[k] - margin * size_, box_.max[k] + margin * size_);
  return p;
}

Ray Aim::exactly_at(const Vec3d& target) const {
  // A coarse step survives the rounding of the origin to float32 more often than not.
  Ray ray;
  for (int attempt = 0; attempt < 16; ++attempt) {
    Vec3d step;
    for (int k = 0; k < 3; ++k) step[k] = quantum_ * random_.integer(-24, 24);
    const double times = random_.chance(0.5) ? 1 : random_.integer(2, 9);
    ray.origin = as_float32(plus(target, -times, step));
    ray.direction = step;
    if (step == Vec3d{0, 0, 0}) continue;
    if (plus(ray.origin, times, step) == target && minus(target, ray.origin) == scaled(step, times))
      return ray;
    ray.direction = as_float32(minus(target, ray.origin));
    if (ray.direction != Vec3d{0, 0, 0} && plus(ray.origin, 1, ray.direction) == target) return ray;
  }
  ensure_valid(ray);
  return ray;
}

Ray Aim::at(const Vec3d& target, double margin) const {
  Ray ray;
  ray.origin = around(margin);
  ray.direction = minus(target, ray.origin);
  ensure_valid(ray);
  return ray;
}

Ray Aim::pixel(const Vec3d& eye, std::size_t i, std::size_t n) const {
  const Vec3d ahead = minus(middle_, eye);
  const Vec3d forward = scaled(ahead, 1 / length(ahead));
  Vec3d right = cross(forward, {0.1, 1, 0.05});
  right = scaled(right, 1 / length(right));
  const Vec3d up = cross(right, forward);
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(n))));
  const std::size_t row = i / side;
  const double x = (static_cast<double>(i % side) + 0.5) / static_cast<double>(side) - 0.5;
  const double y = (static_cast<double>(row) + 0.5) / static_cast<double>(side) - 0.5;
  Ray ray{as_float32(eye), as_float32(plus(plus(forward, x, right), -y, up))};
  ensure_valid(ray);
  return ray;
}

Vec3d nudged(Random& random, Vec3d v, int steps) {
  for (int k = 0; k < 3; ++k) {
    const int count = random.integer(-steps, steps);
    const double towards = count < 0 ? -std::numeric_limits<double>::infinity()
                                     : std::numeric_limits<double>::infinity();
    for (int i = 0; i < std::abs(count); ++i) {
      const double next = std::nextafter(v[k], towards);
      if (std::isfinite(next)) v[k] = next;
    }
  }
  return v;
}

void ensure_valid(Ray& ray) {
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(ray.origin[k])) ray.origin[k] = 0;
    if (!std::isfinite(ray.direction[k])) ray.direction[k] = std::copysign(1.0, ray.direction[k]);
  }
  if (ray.direction == Vec3d{0, 0, 0}) ray.direction.x = 1;
}

}  // namespace sightline::stress
