#include "tests/stress/ray_box_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/infinity.h"

namespace sightline::stress {

namespace {

using oracle::Random;

void sort_corners(Box3d& box) {
  for (int k = 0; k < 3; ++k) {
    if (box.min[k] > box.max[k]) std::swap(box.min[k], box.max[k]);
  }
}

Box3d box_between(const Vec3d& a, const Vec3d& b) {
  Box3d box{a, b};
  sort_corners(box);
  return box;
}

Vec3d grid_point(Random& random, int reach) {
  const int x = random.integer(-reach, reach), y = random.integer(-reach, reach);
  return {static_cast<double>(x), static_cast<double>(y),
          static_cast<double>(random.integer(-reach, reach))};
}

Vec3d grid_direction(Random& random, int reach) {
  for (;;) {
    Vec3d d = grid_point(random, reach);
    if (d.x == 0 && d.y == 0 && d.z == 0) continue;
    for (int k = 0; k < 3; ++k) {
      if (d[k] == 0 && random.chance(0.5)) d[k] = -0.0;
    }
    return d;
  }
}

/// A float64 with few bits, so that sums and small multiples of it are exact.
double short_number(Random& random) {
  return std::ldexp(static_cast<double>(random.integer(-(1 << 20), 1 << 20)), -12);
}
Vec3d short_point(Random& random) {
  const double x = short_number(random), y = short_number(random);
  return {x, y, short_number(random)};
}

/// A corner of the box; `free` axes take some coordinate between the planes instead.
Vec3d point_on(Random& random, const Box3d& box, int free) {
  Vec3d p;
  const int first = random.integer(0, 2);
  for (int i = 0; i < 3; ++i) {
    const int k = (first + i) % 3;
    p[k] = random.chance(0.5) ? box.min[k] : box.max[k];
    if (i < free) p[k] = box.min[k] + std::floor((box.max[k] - box.min[k]) * random.unit());
  }
  return p;
}

Vec3d ahead(const Vec3d& p, const Vec3d& d, double t) {
  return {p.x + t * d.x, p.y + t * d.y, p.z + t * d.z};
}

RayBoxCase ordinary(Random& random) {
  const Vec3d a = random.point(-1, 1), b = random.point(-1, 1);
  return {{random.point(-3, 3), random.direction()}, box_between(a, b), {}};
}

/// Everything on a coarse grid: parallel rays, rays in faces and along edges, flat boxes.
RayBoxCase coarse_grid(Random& random) {
  RayBoxCase c;
  c.aligned = box_between(grid_point(random, 2), grid_point(random, 2));
  c.ray = {grid_point(random, 4), grid_direction(random, 2)};
  return c;
}

/// Exactly through a corner, from a point that is a multiple of the direction away.
RayBoxCase aimed(Random& random, int free) {
  RayBoxCase c;
  c.aligned = box_between(short_point(random), short_point(random));
  const Vec3d d = grid_direction(random, 60);
  const double t = std::ldexp(static_cast<double>(random.integer(-40, 400)), -3);
  c.ray = {ahead(point_on(random, c.aligned, free), d, -t), d};
  return c;
}
RayBoxCase aimed_at_corners(Random& random) { return aimed(random, 0); }
RayBoxCase aimed_at_edges(Random& random) { return aimed(random, 1); }
RayBoxCase aimed_at_faces(Random& random) { return aimed(random, 2); }

/// Through a corner at a t that no float64 holds: the direction is a third, a fifth .. of the way.
RayBoxCase aimed_between_numbers(Random& random) {
  RayBoxCase c = aimed(random, 0);
  const double factor = std::array{3.0, 5.0, 7.0, 11.0}[random.index(4)];
  for (int k = 0; k < 3; ++k) c.ray.direction[k] *= factor;
  return c;
}

/// Through an edge whose two differences plane - origin are not float64 numbers but exact multiples
/// of each other: what divides rounded differences sees one t twice.
RayBoxCase aimed_with_long_differences(Random& random) {
  const double b = std::ldexp(std::floor(random.unit() * 0x1p48), -40);
  const double o = -std::ldexp(std::floor(random.unit() * 0x1p48), -60);
  const double d = std::ldexp(std::floor(1 + random.unit() * 0x1p20), -20);
  constexpr std::array<double, 4> kMultiples{1, 3, 5, 7};
  RayBoxCase c;
  for (int k = 0; k < 3; ++k) {
    const double m = kMultiples[random.index(4)];
    const double sign = random.chance(0.5) ? -1 : 1;
    // The box lies on either side of the plane; a side towards the ray makes it a miss or a touch.
    const double plane = sign * m * b;
    const double other = plane + (random.chance(0.5) ? -1 : 1) * m * b * random.unit();
    c.aligned.min[k] = std::min(plane, other);
    c.aligned.max[k] = std::max(plane, other);
    c.ray.origin[k] = sign * m * o;
    c.ray.direction[k] = sign * m * d;
  }
  return c;
}

/// A ray in the plane of a face, or one number beside it.
RayBoxCase in_a_face(Random& random) {
  RayBoxCase c = ordinary(random);
  const int k = random.integer(0, 2);
  c.ray.origin[k] = random.chance(0.5) ? c.aligned.min[k] : c.aligned.max[k];
  c.ray.direction[k] = random.chance(0.5) ? 0.0 : -0.0;
  if (random.chance(0.3)) {
    c.ray.origin[k] = std::nextafter(c.ray.origin[k], random.chance(0.5) ? kInf : -kInf);
  }
  if (random.chance(0.3)) {
    const int j = (k + 1) % 3;
    c.ray.origin[j] = random.chance(0.5) ? c.aligned.min[j] : c.aligned.max[j];
  }
  return c;
}

/// A ray along one or two slabs, inside of them, in their planes or beside. Some t are far beyond
/// what the vectors decide for such rays.
RayBoxCase parallel(Random& random) {
  RayBoxCase c = ordinary(random);
  const int k = random.integer(0, 2);
  const bool is_far = random.chance(0.2);
  for (int i = 0; i < 3; ++i) {
    if (i == (k + 1) % 3 || (i != k && random.chance(0.5))) {
      if (is_far) c.ray.direction[i] = std::ldexp(c.ray.direction[i], -random.integer(900, 1060));
      continue;
    }
    c.ray.direction[i] = random.chance(0.5) ? 0.0 : -0.0;
    if (random.chance(0.6)) {
      c.ray.origin[i] = random.between(c.aligned.min[i], c.aligned.max[i]);
    } else if (random.chance(0.5)) {
      c.ray.origin[i] = random.chance(0.5) ? c.aligned.min[i] : c.aligned.max[i];
    }
  }
  // It may have been 0, or have become 0.
  if (c.ray.direction == Vec3d{}) c.ray.direction[k] = 1;
  if (random.chance(0.2)) c.aligned.min[random.integer(0, 2)] = -kInf;
  if (random.chance(0.2)) c.ray.tmin = -kInf;
  return c;
}

RayBoxCase origin_on_the_surface(Random& random) {
  RayBoxCase c = aimed(random, 0);
  c.ray.origin = point_on(random, c.aligned, random.integer(0, 2));
  if (random.chance(0.3)) c.ray.tmin = -kInf;
  return c;
}

/// tmin or tmax is the number nearest to a plane's t, or its neighbour.
RayBoxCase limits_at_the_hit(Random& random) {
  RayBoxCase c = random.chance(0.5) ? ordinary(random) : aimed_at_edges(random);
  const auto near_t = [&] {
    const int k = random.integer(0, 2);
    const double plane = random.chance(0.5) ? c.aligned.min[k] : c.aligned.max[k];
    double t = (plane - c.ray.origin[k]) / c.ray.direction[k];
    if (!std::isfinite(t)) t = 0;
    const int way = random.integer(-1, 1);
    return way == 0 ? t : std::nextafter(t, way * kInf);
  };
  c.ray.tmin = random.chance(0.7) ? near_t() : -kInf;
  c.ray.tmax = random.chance(0.7) ? near_t() : kInf;
  if (c.ray.tmin > c.ray.tmax) std::swap(c.ray.tmin, c.ray.tmax);
  return c;
}

RayBoxCase whole_lines(Random& random) {
  RayBoxCase c = coarse_grid(random);
  c.ray.tmin = -kInf;
  return c;
}

/// Open axes and flat boxes.
RayBoxCase open_boxes(Random& random) {
  RayBoxCase c = random.chance(0.5) ? coarse_grid(random) : ordinary(random);
  for (int k = 0; k < 3; ++k) {
    if (random.chance(0.4)) c.aligned.min[k] = -kInf;
    if (random.chance(0.4)) c.aligned.max[k] = kInf;
    if (random.chance(0.2) && std::isfinite(c.aligned.min[k])) c.aligned.max[k] = c.aligned.min[k];
  }
  if (random.chance(0.3)) c.ray.tmin = -kInf;
  if (random.chance(0.3)) c.ray.tmax = random.between(std::max(c.ray.tmin, -3.0), 4);
  return c;
}

void scale(RayBoxCase& c, int space, int direction) {
  for (int k = 0; k < 3; ++k) {
    c.aligned.min[k] = std::ldexp(c.aligned.min[k], space);
    c.aligned.max[k] = std::ldexp(c.aligned.max[k], space);
    c.ray.origin[k] = std::ldexp(c.ray.origin[k], space);
    c.ray.direction[k] = std::ldexp(c.ray.direction[k], direction);
  }
}

/// Denormals, overflowing differences, quotients beyond float64 on both ends.
RayBoxCase extreme_scales(Random& random) {
  RayBoxCase c = random.chance(0.5) ? coarse_grid(random) : aimed_at_corners(random);
  constexpr std::array<int, 6> kExponents{-1074, -1060, -500, 500, 1000, 1012};
  scale(c, kExponents[random.index(6)], kExponents[random.index(5)]);
  const Vec3d& d = c.ray.direction;
  if (d.x == 0 && d.y == 0 && d.z == 0) c.ray.direction.x = 1;
  for (double* x : {&c.ray.origin.x, &c.ray.origin.y, &c.ray.origin.z}) {
    *x = std::clamp(*x, -std::numeric_limits<double>::max(), std::numeric_limits<double>::max());
  }
  if (random.chance(0.3)) c.ray.tmax = random.any_double();
  if (c.ray.tmax < 0) c.ray.tmin = -kInf;
  return c;
}

RayBoxCase any_bits(Random& random) {
  const auto number = [&] { return random.chance(0.2) ? 0.0 : random.any_double(); };
  const auto point = [&] {
    const double x = number(), y = number();
    return Vec3d{x, y, number()};
  };
  RayBoxCase c;
  c.aligned = box_between(point(), point());
  c.ray.origin = point();
  do {
    c.ray.direction = point();
  } while (c.ray.direction == Vec3d{});
  if (random.chance(0.5)) c.ray.tmin = -kInf;
  return c;
}

/// Shifted by 1e8, seen from 1e8 away: every difference is inexact.
RayBoxCase far_away(Random& random) {
  RayBoxCase c = ordinary(random);
  const Vec3d shift = random.point(-1e8, 1e8);
  for (int k = 0; k < 3; ++k) {
    c.aligned.min[k] += shift[k];
    c.aligned.max[k] += shift[k];
    const double to = random.chance(0.5) ? c.aligned.min[k] : c.aligned.max[k];
    c.ray.direction[k] = to - c.ray.origin[k];
  }
  return c;
}

OrientedBox turned_box(Random& random) {
  OrientedBox box;
  box.center = random.point(-1, 1);
  box.half = random.point(0, 1);
  const Vec3d q = random.direction();
  const double angle = random.between(0, 3);
  box.axes = rotated_axes(q.x * std::sin(angle), q.y * std::sin(angle), q.z * std::sin(angle),
                          std::cos(angle));
  return box;
}

RayBoxCase oriented(Random& random) {
  return {{random.point(-3, 3), random.direction()}, {}, turned_box(random)};
}

/// Integer axes (not orthogonal, not unit): corners of the slabs and parallel rays are exact.
RayBoxCase oriented_grid(Random& random) {
  RayBoxCase c;
  OrientedBox box;
  box.center = grid_point(random, 2);
  box.half = {static_cast<double>(random.integer(0, 6)), static_cast<double>(random.integer(0, 6)),
              static_cast<double>(random.integer(0, 6))};
  do {
    for (Vec3d& axis : box.axes) axis = grid_direction(random, 2);
  } while (axes_are_dependent(box.axes));
  if (random.chance(0.1)) box.half[random.integer(0, 2)] = kInf;
  c.oriented = box;
  c.ray = {grid_point(random, 5), grid_direction(random, 3)};
  if (random.chance(0.2)) c.ray.tmin = -kInf;
  return c;
}

/// Quarter turns of coarse boxes, written as quaternions, and directions along their float64 axes.
RayBoxCase oriented_parallel(Random& random) {
  RayBoxCase c = oriented(random);
  OrientedBox& box = *c.oriented;
  const std::size_t k = random.index(3);
  // Perpendicular to one axis by construction where the arithmetic happens to be exact.
  const Vec3d& a = box.axes[k];
  c.ray.direction = random.chance(0.5) ? Vec3d{-a.y, a.x, 0} : Vec3d{0, -a.z, a.y};
  if (c.ray.direction == Vec3d{}) c.ray.direction = a;
  if (random.chance(0.5)) c.ray.origin = box.center;
  if (random.chance(0.3)) box.half[static_cast<int>(k)] = 0;
  return c;
}

RayBoxCase oriented_extremes(Random& random) {
  RayBoxCase c = random.chance(0.5) ? oriented_grid(random) : oriented(random);
  constexpr std::array<int, 6> kExponents{-1040, -700, -300, 300, 500, 1000};
  const int space = kExponents[random.index(6)], axis = kExponents[random.index(5)];
  OrientedBox& box = *c.oriented;
  const int half = std::clamp(space + axis, -1100, 1020);
  for (int k = 0; k < 3; ++k) {
    box.center[k] = std::ldexp(box.center[k], space);
    c.ray.origin[k] = std::ldexp(c.ray.origin[k], space);
    box.half[k] = std::ldexp(box.half[k], half);
    for (Vec3d& a : box.axes) a[k] = std::ldexp(a[k], axis);
  }
  if (random.chance(0.5)) {
    const int direction = kExponents[random.index(6)];
    for (int k = 0; k < 3; ++k) c.ray.direction[k] = std::ldexp(c.ray.direction[k], direction);
    if (c.ray.direction == Vec3d{}) c.ray.direction.y = -1;
  }
  return c;
}

RayBoxCase oriented_any_bits(Random& random) {
  RayBoxCase c = any_bits(random);
  OrientedBox box;
  box.center = {random.any_double(), random.any_double(), random.any_double()};
  box.half = {std::abs(random.any_double()), std::abs(random.any_double()), kInf};
  for (Vec3d& axis : box.axes) {
    axis = {random.any_double(), random.any_double(), random.chance(0.3) ? 0 : random.any_double()};
  }
  c.oriented = box;
  return c;
}

constexpr std::array<RayBoxFamily, 21> kFamilies{{
    {"ordinary", 1, ordinary},
    {"coarse_grid", 2, coarse_grid},
    {"aimed_at_corners", 3, aimed_at_corners},
    {"aimed_at_edges", 3, aimed_at_edges},
    {"aimed_at_faces", 2, aimed_at_faces},
    {"aimed_between_numbers", 3, aimed_between_numbers},
    {"aimed_with_long_differences", 2, aimed_with_long_differences},
    {"in_a_face", 2, in_a_face},
    {"parallel", 2, parallel},
    {"origin_on_the_surface", 3, origin_on_the_surface},
    {"limits_at_the_hit", 2, limits_at_the_hit},
    {"whole_lines", 2, whole_lines},
    {"open_boxes", 1, open_boxes},
    {"extreme_scales", 1, extreme_scales},
    {"any_bits", 1, any_bits},
    {"far_away", 1, far_away},
    {"oriented", 1, oriented},
    {"oriented_grid", 1, oriented_grid},
    {"oriented_parallel", 1, oriented_parallel},
    {"oriented_extremes", 1, oriented_extremes},
    {"oriented_any_bits", 1, oriented_any_bits},
}};

}  // namespace

std::span<const RayBoxFamily> ray_box_families() { return kFamilies; }

}  // namespace sightline::stress
