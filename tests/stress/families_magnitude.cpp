#include <bit>
#include <cmath>

#include "core/base/infinity.h"
#include "tests/stress/aims.h"
#include "tests/stress/meshes.h"

namespace sightline::stress {
namespace {

void aim_everywhere(const Aim& aim, std::size_t count, RayBatch& rays) {
  Random& r = aim.random();
  while (rays.size() < count) {
    const Vec3d target = r.chance(0.3)   ? aim.corner()
                         : r.chance(0.5) ? aim.edge_point()
                                         : aim.inner_point();
    Ray ray = aim.at(target);
    if (r.chance(0.4)) ray = aim.exactly_at(target);
    if (r.chance(0.2)) ray.direction = nudged(r, ray.direction, 1);
    ensure_valid(ray);
    rays.push_back(ray);
  }
}

/// A ball whose float32 corners are `scale` times those of a unit ball.
MeshPointer ball_of_size(Random& random, double scale) {
  MeshMaker maker;
  maker.ball(random, {0.1 * scale, 0, -0.2 * scale}, scale, 20, 40, 0.05);
  return maker.finish();
}

Case at_scale(Random& random, std::size_t count, double scale) {
  Case result{scene_of(ball_of_size(random, scale)), {}, true};
  aim_everywhere(Aim(result.scene, random), count, result.rays);
  return result;
}

Case placed_at_scale(Random& random, std::size_t count) {
  // The matrix makes float64 corners that no float32 holds.
  const double scale = std::pow(10, random.between(-290, 290));
  Case result{scene_of({scan(random, 2500)}, {scaling(scale, scale, scale)}), {}, true};
  aim_everywhere(Aim(result.scene, random), count, result.rays);
  return result;
}

Case long_and_short_directions(Random& random, std::size_t count) {
  Case result{scene_of(scan(random, 4000)), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray = random.chance(0.5) ? aim.exactly_at(aim.corner()) : aim.at(aim.inner_point());
    const int power = random.integer(-1074, 1023);
    for (int k = 0; k < 3; ++k) ray.direction[k] = std::ldexp(ray.direction[k], power);
    if (random.chance(0.2)) ray.tmax = std::ldexp(random.unit(), random.integer(-1070, 1020));
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case float_bits(Random& random, std::size_t count) {
  // Few corners of any float32 bit pattern, used again and again.
  MeshMaker maker;
  std::vector<float> pool;
  pool.reserve(14);
  for (int i = 0; i < 12; ++i) pool.push_back(random.any_float());
  pool.push_back(0.0F);
  pool.push_back(1.0F);
  const auto number = [&] { return static_cast<double>(pool[random.index(pool.size())]); };
  for (int i = 0; i < 200; ++i)
    maker.triangle({number(), number(), number()}, {number(), number(), number()},
                   {number(), number(), number()});
  Case result{scene_of(maker.finish()), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray{{number(), number(), number()}, {number(), number(), number()}};
    switch (random.index(4)) {
      case 0:
        ray.direction = minus(aim.corner(), ray.origin);
        break;
      case 1:
        ray.direction = minus(aim.edge_point(), ray.origin);
        break;
      case 2:
        for (int k = 0; k < 3; ++k) ray.direction[k] = random.any_double();
        break;
      default:
        break;
    }
    if (random.chance(0.2)) ray.tmin = -kInf;
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case double_bits(Random& random, std::size_t count) {
  // Any float64 bit patterns in the matrix, the origin, the direction and the limits.
  MeshMaker maker;
  for (int i = 0; i < 40; ++i) {
    const auto lattice = [&] {
      const double x = random.integer(-2, 2), y = random.integer(-2, 2);
      return Vec3d{x, y, static_cast<double>(random.integer(-2, 2))};
    };
    maker.triangle(lattice(), lattice(), lattice());
  }
  const MeshPointer mesh = maker.finish();
  std::vector<double> pool{0, 1, -1};
  for (int i = 0; i < 8; ++i) pool.push_back(random.any_double());
  const auto number = [&] { return pool[random.index(pool.size())]; };
  SceneDescription scene = scene_of({mesh}, {Affine{}});
  for (int i = 0; i < 3; ++i) {
    Affine matrix;
    for (auto& row : matrix.m) {
      for (double& value : row) value = random.chance(0.3) ? 0 : number();
    }
    place(scene, 0, matrix);
  }
  Case result{std::move(scene), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray{{number(), number(), number()}, {number(), number(), number()}};
    if (random.chance(0.6)) ray.direction = minus(aim.inner_point(), ray.origin);
    if (random.chance(0.2)) ray.tmin = random.any_double();
    if (random.chance(0.2)) ray.tmax = random.any_double();
    if (ray.tmin > ray.tmax) std::swap(ray.tmin, ray.tmax);
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case mixed_magnitudes(Random& random, std::size_t count) {
  // Powers of two from 2^-120 to 2^120 side by side: sums lose everything but the largest.
  MeshMaker maker;
  const auto number = [&] {
    return std::ldexp(random.integer(-3, 3), random.chance(0.5) ? 0 : random.integer(-120, 120));
  };
  for (int i = 0; i < 150; ++i)
    maker.triangle({number(), number(), number()}, {number(), number(), number()},
                   {number(), number(), number()});
  Case result{scene_of(maker.finish()), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray{{number(), number(), number()}, {number(), number(), number()}};
    if (random.chance(0.5)) ray.direction = minus(aim.edge_point(), ray.origin);
    if (random.chance(0.2)) ray.origin = aim.corner();
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case beyond_the_range(Random& random, std::size_t count) {
  // Corners near the largest float64, and placements that overflow: those triangles are dropped.
  SceneDescription scene = scene_of({ball_of_size(random, 1), ball_of_size(random, 1e38)}, {});
  place(scene, 0, scaling(1e308, 1e308, 1e308));
  place(scene, 1, scaling(1e269, 1e269, 1e269));
  place(scene, 1, scaling(1e271, 1, 1));
  place(scene, 0, Affine{});
  Case result{std::move(scene), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray = aim.at(random.chance(0.5) ? aim.corner() : aim.inner_point(), 0.01);
    if (random.chance(0.5)) ray.origin = random.point(-2, 2);
    if (random.chance(0.5)) ray.direction = scaled(minus(aim.corner(), ray.origin), 0x1p-10);
    if (random.chance(0.2)) ray.tmin = -kInf;
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

/// Triangles of small integers, flattened by a power of two so that a ray from 2^50 to 2^900 away
/// needs a few of the least float64 as a component of its direction to meet them: all of it exact.
Case least_components_from_afar(Random& random, std::size_t count) {
  MeshMaker maker;
  const auto corner = [&] {
    const double x = random.integer(-5, 5), y = random.integer(-5, 5);
    return Vec3d{x, y, static_cast<double>(random.integer(-20, 20))};
  };
  for (int i = 0; i < 300; ++i) maker.triangle(corner(), corner(), corner());
  const int away = random.integer(50, 900);
  const int flat = random.integer(0, 2);  // this axis is flattened, the ray comes along another
  const int along = (flat + random.integer(1, 2)) % 3;
  Affine placement = scaling(1, 1, 1);
  placement.m[flat][flat] = std::ldexp(1.0, away - 1074);
  Case result{scene_of({maker.finish()}, {placement}), {}, false};
  const Aim aim(result.scene, random);
  const double unit = placement.m[flat][flat];
  while (result.rays.size() < count) {
    const Vec3d target = aim.corner();
    Ray ray{target, {0, 0, 0}};
    const double toward = (random.chance(0.5) ? 1 : -1) * random.integer(1, 7);
    const int steps = random.integer(-15, 15);
    ray.direction[along] = toward;
    ray.direction[flat] = steps * 0x1p-1074;
    ray.origin[along] = std::ldexp(-toward, away);
    ray.origin[flat] = target[flat] - steps * unit;
    if (random.chance(0.3)) ray.tmax = std::ldexp(1.0, away);
    if (random.chance(0.3)) ray.tmin = random.chance(0.5) ? -kInf : std::ldexp(0.5, away);
    result.rays.push_back(ray);
  }
  return result;
}

}  // namespace

std::vector<Family> magnitude_families() {
  return {
      {"scale_1e-30", "float32 corners of a ball of radius 1e-30",
       [](Random& r, std::size_t n) { return at_scale(r, n, 1e-30); }},
      {"scale_1e30", "float32 corners of a ball of radius 1e30",
       [](Random& r, std::size_t n) { return at_scale(r, n, 1e30); }},
      {"scale_1e-40", "corners that are float32 denormals",
       [](Random& r, std::size_t n) { return at_scale(r, n, 1e-40); }},
      {"scale_of_the_placement", "a matrix that scales by 1e-290 to 1e290", placed_at_scale},
      {"directions_of_any_length", "directions of 2^-1074 to 2^1023: t underflows and overflows",
       long_and_short_directions},
      {"float32_bit_patterns", "random float32 bit patterns as coordinates", float_bits},
      {"float64_bit_patterns", "random float64 bit patterns in matrices, rays and limits",
       double_bits},
      {"mixed_magnitudes", "2^-120 beside 2^120", mixed_magnitudes},
      {"least_components_from_afar",
       "directions with a few of the least float64 as a component, from 2^50 to 2^900 away",
       least_components_from_afar},
      {"beyond_the_range", "corners near 1.8e308 and placements that overflow", beyond_the_range},
  };
}

}  // namespace sightline::stress
