#include <cmath>

#include "core/base/infinity.h"
#include "tests/oracle/rational.h"
#include "tests/stress/aimed_rays.h"
#include "tests/stress/meshes.h"

namespace sightline::stress {
namespace {

/// The closed scan and `count` rays made by `ray(aim)`.
template <class MakeRay>
Case scan_case(Random& random, std::size_t count, MakeRay&& make_ray) {
  Case result{scene_of(scan(random, 6000)), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) result.rays.push_back(make_ray(aim));
  return result;
}

/// One of aimed_families() at the closed scan.
Family at_the_scan(const char* name, const char* what) {
  const AimedFamily& family = aimed_family(name);
  return {name, what, [&family](Random& random, std::size_t count) {
            return scan_case(random, count, family.ray);
          }};
}

Case camera(Random& random, std::size_t count) {
  Case result{scene_of(scan(random, 20000)), {}, true};
  const Aim aim(result.scene, random);
  const std::size_t view = std::max<std::size_t>(1, count / 4);
  Vec3d eye;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % view == 0) eye = plus(aim.middle(), 1.5 * aim.size(), random.direction());
    result.rays.push_back(aim.pixel(eye, i % view, view));
  }
  return result;
}

Case cube_faces(Random& random, std::size_t count) {
  Case result{scene_of(stacked_cubes(6)), {}, true};
  while (result.rays.size() < count) {
    // Along an axis, with one of the other two coordinates in a face.
    const int axis = random.integer(0, 2);
    Ray ray;
    for (int k = 0; k < 3; ++k) ray.origin[k] = 0.0625 * random.integer(-8, 104);
    ray.origin[(axis + random.integer(1, 2)) % 3] = random.integer(0, 6);
    ray.origin[axis] = random.chance(0.7) ? -1.5 : 0.5 * random.integer(-1, 13);
    ray.direction = {random.chance(0.5) ? 0.0 : -0.0, random.chance(0.5) ? 0.0 : -0.0,
                     random.chance(0.5) ? 0.0 : -0.0};
    ray.direction[axis] = random.chance(0.5) ? 1 : random.chance(0.5) ? 0.375 : 3;
    if (random.chance(0.5)) {
      ray.origin[axis] = 6 - ray.origin[axis];
      ray.direction[axis] = -ray.direction[axis];
    }
    result.rays.push_back(ray);
  }
  return result;
}

Case slivers(Random& random, std::size_t count) {
  MeshMaker maker;
  for (int i = 0; i < 1500; ++i) {
    const Vec3d a = random.point(-10, 10);
    const Vec3d along = scaled(random.direction(), random.between(1, 10));
    const Vec3d across = scaled(random.direction(), 1e-6 * length(along));
    maker.triangle(a, plus(a, 1, along), plus(plus(a, random.unit(), along), 1, across));
  }
  Case result{scene_of(maker.finish()), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    const Ray ray = aim.at(aim.inner_point(), 0.1);
    result.rays.push_back(
        random.chance(0.5) ? ray : Ray{as_float32(ray.origin), as_float32(ray.direction)});
  }
  return result;
}

Case shifted(Random& random, std::size_t count) {
  const Affine away = translation(1e8 + random.integer(0, 1000), -1e8, 1e8 + random.unit());
  Case result{scene_of({scan(random, 6000)}, {away}), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray = aim.at(any_target(aim));
    if (random.chance(0.3)) ray.direction = nudged(random, ray.direction, 2);
    result.rays.push_back(ray);
  }
  return result;
}

Case limits_at_hit(Random& random, std::size_t count) {
  return scan_case(random, count, [](const Aim& aim) {
    Random& r = aim.random();
    const Triangle& w = aim.triangle();
    const Vec3d target = r.chance(0.3) ? w.v1 : point_of(w, 0.25, r.unit() * 0.5);
    Ray ray = aim.at(target);
    if (r.chance(0.5)) ray = {as_float32(ray.origin), as_float32(ray.direction)};
    ensure_valid(ray);
    const auto exact = oracle::least_t({ray.origin, ray.direction, -kInf, kInf}, w);
    double t = exact ? oracle::round_to_double(*exact) : 1;
    if (r.chance(0.5)) t = std::nextafter(t, r.chance(0.5) ? kInf : -kInf);
    switch (r.index(3)) {
      case 0:
        ray.tmin = t;
        break;
      case 1:
        ray.tmax = t;
        ray.tmin = std::min(0.0, t);
        break;
      default:
        ray.tmin = ray.tmax = t;
    }
    return ray;
  });
}

}  // namespace

std::vector<Family> contract_families() {
  return {
      {"camera", "pinhole views of a closed scan", camera},
      at_the_scan("vertex_aims", "float32 rays exactly through a vertex"),
      at_the_scan("edge_aims",
                  "float32 rays exactly through a point of an edge, where the numbers allow it"),
      at_the_scan("near_edges_float64", "float64 rays a few numbers beside an edge or a vertex"),
      {"axis_rays_in_cube_faces", "axis rays in the faces of stacked cubes", cube_faces},
      at_the_scan("origin_on_surface", "the origin on a vertex, an edge or a triangle"),
      at_the_scan("in_a_triangles_plane", "the ray lies exactly in a triangle's plane"),
      at_the_scan("grazing", "1e-9 to 1e-2 rad over a triangle"),
      {"slivers_1e-6", "triangles a million times longer than wide", slivers},
      {"shifted_1e8_float64", "a scene shifted by 1e8, float64 rays", shifted},
      at_the_scan("origin_far_away", "the origin 1e5 to 1e8 scene sizes away"),
      {"limits_at_the_hit", "tmin or tmax at the rounded t of a hit or one number beside it",
       limits_at_hit},
  };
}

}  // namespace sightline::stress
