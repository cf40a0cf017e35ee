#include "tests/crosscheck/rays.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/box3.h"
#include "tests/oracle/narrow.h"
#include "tests/oracle/random.h"

namespace sightline::crosscheck {
namespace {

using oracle::Random;
using oracle::Triangle;

double to_float(double value) { return oracle::to_float32(value); }
Vec3d to_float(const Vec3d& v) { return {to_float(v.x), to_float(v.y), to_float(v.z)}; }
Vec3d minus(const Vec3d& a, const Vec3d& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3d plus(const Vec3d& a, double s, const Vec3d& b) {
  return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(const Vec3d& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }
Vec3d unit(const Vec3d& v) {
  const double size = length(v);
  return {v.x / size, v.y / size, v.z / size};
}
bool is_zero(const Vec3d& v) { return v == Vec3d{0, 0, 0}; }

/// The box of the finite corners, not flat.
Box3d thick_bounds(std::span<const Triangle> triangles) {
  Box3d box;
  for (const Triangle& triangle : triangles) {
    if (!oracle::is_finite(triangle)) continue;
    for (const Vec3d& v : {triangle.v0, triangle.v1, triangle.v2}) box.include(v);
  }
  const double margin = 0.05 * length(minus(box.max, box.min));
  for (int k = 0; k < 3; ++k) {
    box.min[k] -= margin;
    box.max[k] += margin;
  }
  return box;
}

class Source {
 public:
  Source(std::span<const Triangle> triangles, std::uint64_t seed)
      : triangles_(triangles), random_(seed), box_(thick_bounds(triangles)) {
    diagonal_ = length(minus(box_.max, box_.min));
    for (int k = 0; k < 3; ++k) middle_[k] = 0.5 * (box_.min[k] + box_.max[k]);
    quantum_ = std::exp2(std::floor(std::log2(diagonal_)) - 8);
  }

  /// Pixel `pixel` of `pixels` of one of four views, two from outside and two from inside.
  Ray camera(std::size_t view, std::size_t pixel, std::size_t pixels) {
    const Vec3d ways[] = {{0.6, 0.5, 0.7}, {-0.8, 0.3, -0.4}, {0.1, 0.05, 0.2}, {-0.15, 0.1, 0.05}};
    const Vec3d eye = plus(middle_, diagonal_, ways[view]);
    const Vec3d forward = unit(minus(middle_, eye));
    const Vec3d right = unit(cross(forward, {0.1, 1, 0.05}));
    const Vec3d up = cross(right, forward);
    const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(pixels))));
    const std::size_t row = pixel / side;
    const double x = 1.2 * (static_cast<double>(pixel % side) + 0.5) / static_cast<double>(side);
    const double y = 1.2 * (static_cast<double>(row) + 0.5) / static_cast<double>(side);
    return {to_float(eye), to_float(plus(plus(forward, x - 0.6, right), 0.6 - y, up))};
  }

  Ray incoherent() {
    Vec3d origin;
    for (int k = 0; k < 3; ++k) origin[k] = random_.between(box_.min[k], box_.max[k]);
    return {to_float(origin), to_float(random_.direction())};
  }

  Ray at_corner() {
    const Triangle& triangle = pick();
    return towards(std::array{triangle.v0, triangle.v1, triangle.v2}[random_.index(3)]);
  }

  Ray at_edge() {
    const Triangle& triangle = pick();
    const double s = random_.chance(0.7) ? random_.integer(1, 7) * 0.125 : random_.unit();
    return towards(plus(triangle.v1, s, minus(triangle.v2, triangle.v1)));
  }

  void limit(Ray& ray) {
    const double scale = diagonal_ / length(ray.direction);
    ray.tmin = to_float(random_.chance(0.5) ? 0 : 0.2 * scale * random_.unit());
    ray.tmax = to_float(ray.tmin + scale * random_.unit());
  }
  bool chance(double probability) { return random_.chance(probability); }

 private:
  const Triangle& pick() {
    for (;;) {
      const Triangle& triangle = triangles_[random_.index(triangles_.size())];
      if (oracle::is_finite(triangle)) return triangle;
    }
  }

  /// A coarse step away from the target survives the rounding to float32 more often than not, and
  /// then the way back is exact.
  Ray towards(const Vec3d& target) {
    for (;;) {
      Vec3d step;
      for (int k = 0; k < 3; ++k) step[k] = quantum_ * random_.integer(-96, 96);
      const Vec3d origin = to_float(plus(target, -1, step));
      const Vec3d direction = to_float(minus(target, origin));
      if (!is_zero(direction)) return {origin, direction};
    }
  }

  std::span<const Triangle> triangles_;
  Random random_;
  Box3d box_;
  Vec3d middle_;
  double diagonal_ = 0;
  double quantum_ = 0;
};

}  // namespace

RayBatch mixed_rays(std::span<const Triangle> triangles, std::size_t count, std::uint64_t seed) {
  Source source(triangles, seed);
  RayBatch rays;
  rays.reserve(count);
  const std::size_t pixels = count * 35 / 400;  // per view
  for (std::size_t view = 0; view < 4; ++view) {
    for (std::size_t i = 0; i < pixels; ++i) rays.push_back(source.camera(view, i, pixels));
  }
  while (rays.size() < count) {
    const std::size_t part = (rays.size() - 4 * pixels) * 65 / (count - 4 * pixels);
    Ray ray = part < 25 ? source.incoherent() : part < 45 ? source.at_corner() : source.at_edge();
    if (source.chance(0.125)) source.limit(ray);
    rays.push_back(ray);
  }
  return rays;
}

}  // namespace sightline::crosscheck
