#include "tests/stress/aimed_rays.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/infinity.h"

namespace sightline::stress {
namespace {

Ray vertex_aim(const Aim& aim) { return aim.exactly_at(aim.corner()); }

Ray edge_aim(const Aim& aim) { return aim.exactly_at(aim.edge_point()); }

Ray near_edge(const Aim& aim) {
  const Vec3d target = aim.random().chance(0.7) ? aim.edge_point() : aim.corner();
  Ray ray = aim.at(target);
  ray.direction = nudged(aim.random(), ray.direction, 3);
  if (aim.random().chance(0.3)) ray.origin = nudged(aim.random(), ray.origin, 3);
  return ray;
}

Ray from_surface(const Aim& aim) {
  Random& r = aim.random();
  Vec3d origin = r.chance(0.3)   ? aim.corner()
                 : r.chance(0.5) ? aim.edge_point()
                                 : aim.inner_point();
  if (r.chance(0.5)) origin = as_float32(origin);
  Ray ray{origin, as_float32(r.direction())};
  if (r.chance(0.3)) ray.direction = minus(aim.corner(), origin);
  ensure_valid(ray);
  return ray;
}

Ray in_plane_ray(const Aim& aim) {
  Random& r = aim.random();
  const Triangle& w = aim.triangle();
  // Whole multiples of float32 edges are exact in float64: the ray lies in the plane exactly.
  const Vec3d from = r.chance(0.8) ? point_of(w, r.integer(-3, 3), r.integer(-3, 3))
                                   : point_of(w, r.between(-3, 3), r.between(-3, 3));
  const Vec3d to = r.chance(0.8) ? point_of(w, 0.5 * r.integer(0, 2), 0.5 * r.integer(0, 2))
                                 : point_of(w, r.unit(), r.unit());
  Ray ray{from, minus(to, from)};
  if (r.chance(0.2)) ray.tmin = -kInf;
  if (r.chance(0.2)) ray.tmin = 0.25 * r.integer(0, 4);
  if (r.chance(0.2)) ray.tmax = std::max(ray.tmin, 0.25 * r.integer(0, 6));
  ensure_valid(ray);
  return ray;
}

Ray grazing_ray(const Aim& aim) {
  Random& r = aim.random();
  const Triangle& w = aim.triangle();
  const Vec3d normal = cross(minus(w.v1, w.v0), minus(w.v2, w.v0));
  const double tilt = std::pow(10, r.between(-9, -2)) / length(normal);
  const Vec3d target = point_of(w, r.between(-0.2, 1), r.between(-0.2, 1));
  const Vec3d along = minus(point_of(w, r.between(-2, 2), r.between(-2, 2)), target);
  Ray ray;
  ray.direction = plus(scaled(along, 1 / length(along)), tilt, normal);
  ray.origin = plus(target, -r.between(0.1, 2), ray.direction);
  if (r.chance(0.7)) ray = {as_float32(ray.origin), as_float32(ray.direction)};
  ensure_valid(ray);
  return ray;
}

Ray far_origin_ray(const Aim& aim) {
  Random& r = aim.random();
  const Vec3d target = any_target(aim);
  const double distance = std::pow(10, r.between(5, 8)) * aim.size();
  Ray ray;
  ray.origin = plus(target, distance, r.direction());
  if (r.chance(0.5)) ray.origin = as_float32(ray.origin);
  ray.direction = minus(target, ray.origin);
  if (r.chance(0.5)) ray.direction = scaled(ray.direction, 1 / length(ray.direction));
  ensure_valid(ray);
  return ray;
}

constexpr std::array<AimedFamily, 7> kFamilies{{
    {"vertex_aims", vertex_aim},
    {"edge_aims", edge_aim},
    {"near_edges_float64", near_edge},
    {"origin_on_surface", from_surface},
    {"in_a_triangles_plane", in_plane_ray},
    {"grazing", grazing_ray},
    {"origin_far_away", far_origin_ray},
}};

}  // namespace

Vec3d any_target(const Aim& aim) {
  switch (aim.random().index(3)) {
    case 0:
      return aim.corner();
    case 1:
      return aim.edge_point();
    default:
      return aim.inner_point();
  }
}

std::span<const AimedFamily> aimed_families() { return kFamilies; }

const AimedFamily& aimed_family(std::string_view name) {
  return *std::find_if(kFamilies.begin(), kFamilies.end(),
                       [&](const AimedFamily& family) { return family.name == name; });
}

}  // namespace sightline::stress
