#include "tests/stress/triangle_box_cases.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/infinity.h"

namespace sightline::stress {

namespace {

using oracle::Random;

Vec3d sum(const Vec3d& a, const Vec3d& b, double factor = 1) {
  return {a.x + factor * b.x, a.y + factor * b.y, a.z + factor * b.z};
}

Vec3d grid_point(Random& random, int reach) {
  const int x = random.integer(-reach, reach), y = random.integer(-reach, reach);
  return {static_cast<double>(x), static_cast<double>(y),
          static_cast<double>(random.integer(-reach, reach))};
}

Box3d box_between(const Vec3d& a, const Vec3d& b) {
  Box3d box;
  box.include(a);
  box.include(b);
  return box;
}

std::array<Vec3d*, 3> corners(Triangle& t) { return {&t.v0, &t.v1, &t.v2}; }

void shuffle(Random& random, Triangle& t) {
  if (random.chance(0.5)) std::swap(t.v0, t.v1);
  if (random.chance(0.5)) std::swap(t.v1, t.v2);
}

/// Sometimes one coordinate moves to the neighbouring number: what touched overlaps or misses.
void nudge(Random& random, TriangleBoxCase& c) {
  if (!random.chance(0.4)) return;
  double& x = (*corners(c.triangle)[random.index(3)])[random.integer(0, 2)];
  x = std::nextafter(x, random.chance(0.5) ? kInf : -kInf);
}

TriangleBoxCase ordinary(Random& random) {
  const Vec3d a = random.point(-1, 1), b = random.point(-1, 1);
  const double reach = random.chance(0.5) ? 1.5 : 0.2;
  const Vec3d at = random.point(-1.2, 1.2);
  const auto corner = [&] { return sum(at, random.point(-reach, reach)); };
  const Vec3d v0 = corner(), v1 = corner();
  return {{v0, v1, corner()}, box_between(a, b), {}};
}

/// Everything on a coarse grid: flat boxes, triangles in planes, no area.
TriangleBoxCase coarse_grid(Random& random) {
  const Vec3d a = grid_point(random, 2), b = grid_point(random, 2);
  const Vec3d v0 = grid_point(random, 4), v1 = grid_point(random, 4);
  return {{v0, v1, grid_point(random, 4)}, box_between(a, b), {}};
}

/// A box of short numbers, one of its corners, and the signs that point outwards there.
struct Corner {
  Box3d box;
  Vec3d at, outward;
};
Corner make_corner(Random& random) {
  Corner c;
  const auto number = [&] {
    return std::ldexp(static_cast<double>(random.integer(-99999, 99999)), -10);
  };
  const double x = number(), y = number(), z = number();
  c.at = {x, y, z};
  Vec3d other;
  for (int k = 0; k < 3; ++k) {
    c.outward[k] = random.chance(0.5) ? 1 : -1;
    other[k] = c.at[k] - c.outward[k] * static_cast<double>(random.integer(0, 50));
  }
  c.box = box_between(c.at, other);
  return c;
}

/// A whole vector, of mixed signs, that has a certain sum of outward components.
Vec3d whole_vector(Random& random) { return grid_point(random, 30); }

/// The box's corner in the middle of a triangle whose plane supports the box there.
TriangleBoxCase corner_in_triangle(Random& random) {
  const Corner c = make_corner(random);
  // a and b span a plane with a normal in the outward octant: n . a = n . b = 0.
  const Vec3d n{c.outward.x * random.integer(1, 9), c.outward.y * random.integer(1, 9),
                c.outward.z * random.integer(1, 9)};
  const Vec3d a{n.y, -n.x, 0}, b{0, n.z, -n.y};
  const double i = random.integer(-3, 3), j = random.integer(-3, 3);
  const Vec3d p = sum(sum({}, a, i), b, j), q = sum(sum({}, a, -j), b, i + 1);
  TriangleBoxCase out{{sum(c.at, p), sum(c.at, q), sum(sum(c.at, p, -1), q, -1)}, c.box, {}};
  shuffle(random, out.triangle);
  nudge(random, out);
  return out;
}

/// An edge of the triangle through an edge of the box, the third corner on the outer side.
TriangleBoxCase edge_on_edge(Random& random) {
  const Corner c = make_corner(random);
  const int k = random.integer(0, 2), i = (k + 1) % 3, j = (k + 2) % 3;
  Vec3d at = c.at;
  at[k] = (c.box.min[k] + c.box.max[k]) / 2;
  // Across the corner of the other two axes: outward on one, inward on the other.
  Vec3d d = whole_vector(random);
  d[i] = c.outward[i] * random.integer(1, 9);
  d[j] = -c.outward[j] * random.integer(1, 9);
  Vec3d away = whole_vector(random);
  away[i] = c.outward[i] * random.integer(0, 9);
  away[j] = c.outward[j] * random.integer(0, 9);
  TriangleBoxCase out{
      {sum(at, d, -random.integer(1, 5)), sum(at, d, random.integer(1, 5)), sum(at, away)},
      c.box,
      {}};
  shuffle(random, out.triangle);
  nudge(random, out);
  return out;
}

/// A corner of the triangle in a face, on an edge or at a corner of the box, the rest outside.
TriangleBoxCase corner_on_surface(Random& random) {
  const Corner c = make_corner(random);
  const int k = random.integer(0, 2);
  Vec3d at = c.at;
  for (int i = 0; i < 3; ++i) {
    if (i != k && random.chance(0.6)) at[i] = (c.box.min[i] + c.box.max[i]) / 2;
  }
  TriangleBoxCase out;
  out.aligned = c.box;
  out.triangle = {at, sum(at, whole_vector(random)), sum(at, whole_vector(random))};
  for (Vec3d* v : {&out.triangle.v1, &out.triangle.v2}) {
    (*v)[k] = at[k] + c.outward[k] * random.integer(0, 20);
  }
  shuffle(random, out.triangle);
  nudge(random, out);
  return out;
}

/// In the plane of a face.
TriangleBoxCase in_a_face(Random& random) {
  TriangleBoxCase c = ordinary(random);
  const int k = random.integer(0, 2);
  const double plane = random.chance(0.5) ? c.aligned.min[k] : c.aligned.max[k];
  for (Vec3d* v : corners(c.triangle)) (*v)[k] = plane;
  nudge(random, c);
  return c;
}

TriangleBoxCase slivers(Random& random) {
  TriangleBoxCase c = random.chance(0.5) ? ordinary(random) : edge_on_edge(random);
  const double s = random.between(-0.5, 1.5);
  Triangle& t = c.triangle;
  for (int k = 0; k < 3; ++k) {
    t.v2[k] = t.v0[k] + s * (t.v1[k] - t.v0[k]) + random.between(-1, 1) * 1e-15;
  }
  return c;
}

TriangleBoxCase no_area(Random& random) {
  TriangleBoxCase c = coarse_grid(random);
  const double s = random.integer(-3, 3);
  c.triangle.v2 = sum(c.triangle.v0, sum(c.triangle.v1, c.triangle.v0, -1), s);
  return c;
}

TriangleBoxCase open_boxes(Random& random) {
  TriangleBoxCase c = random.chance(0.6) ? coarse_grid(random) : ordinary(random);
  for (int k = 0; k < 3; ++k) {
    if (random.chance(0.4)) c.aligned.min[k] = -kInf;
    if (random.chance(0.4)) c.aligned.max[k] = kInf;
  }
  return c;
}

/// Points and plates: half sizes of zero, on the triangle or beside it.
TriangleBoxCase flat_boxes(Random& random) {
  TriangleBoxCase c = random.chance(0.5) ? coarse_grid(random) : ordinary(random);
  if (random.chance(0.3)) {
    const Triangle& t = c.triangle;
    c.aligned.min = c.aligned.max =
        sum(sum(t.v0, sum(t.v1, t.v0, -1), 0.25), sum(t.v2, t.v0, -1), 0.5);
    return c;
  }
  for (int k = 0; k < 3; ++k) {
    if (random.chance(0.6)) c.aligned.max[k] = c.aligned.min[k];
  }
  return c;
}

TriangleBoxCase shifted(Random& random) {
  TriangleBoxCase c = edge_on_edge(random);
  const Vec3d shift = grid_point(random, 100000000);
  for (Vec3d* v : corners(c.triangle)) *v = sum(*v, shift);
  c.aligned.min = sum(c.aligned.min, shift);
  c.aligned.max = sum(c.aligned.max, shift);
  return c;
}

TriangleBoxCase extreme_scales(Random& random) {
  TriangleBoxCase c = random.chance(0.5) ? coarse_grid(random) : edge_on_edge(random);
  constexpr std::array<int, 6> kExponents{-1064, -700, -350, 330, 500, 1000};
  const int exponent = kExponents[random.index(6)];
  for (int k = 0; k < 3; ++k) {
    for (Vec3d* v : corners(c.triangle)) (*v)[k] = std::ldexp((*v)[k], exponent);
    c.aligned.min[k] = std::ldexp(c.aligned.min[k], exponent);
    c.aligned.max[k] = std::ldexp(c.aligned.max[k], exponent);
  }
  return c;
}

TriangleBoxCase any_bits(Random& random) {
  const auto point = [&] {
    const double x = random.any_double(), y = random.any_double();
    return Vec3d{x, y, random.any_double()};
  };
  TriangleBoxCase c;
  c.triangle = {point(), point(), point()};
  c.aligned = box_between(point(), point());
  return c;
}

TriangleBoxCase oriented(Random& random) {
  TriangleBoxCase c = ordinary(random);
  const Vec3d q = random.direction();
  const double angle = random.between(0, 3);
  const double s = std::sin(angle);
  c.oriented = {random.point(-1, 1), random.point(0, 1),
                rotated_axes(q.x * s, q.y * s, q.z * s, std::cos(angle))};
  return c;
}

/// Whole axes, neither unit nor orthogonal; often a half size that just reaches a corner.
TriangleBoxCase oriented_grid(Random& random) {
  TriangleBoxCase c = coarse_grid(random);
  OrientedBox box;
  box.center = grid_point(random, 2);
  do {
    for (Vec3d& axis : box.axes) axis = grid_point(random, 2);
  } while (axes_are_dependent(box.axes));
  for (int k = 0; k < 3; ++k) {
    box.half[k] = random.integer(0, 9);
    if (random.chance(0.4)) {
      const Vec3d& a = box.axes[static_cast<std::size_t>(k)];
      const Vec3d from = sum(*corners(c.triangle)[random.index(3)], box.center, -1);
      box.half[k] = std::abs(a.x * from.x + a.y * from.y + a.z * from.z);
    }
  }
  if (random.chance(0.1)) box.half[random.integer(0, 2)] = kInf;
  c.oriented = box;
  nudge(random, c);
  return c;
}

TriangleBoxCase oriented_extremes(Random& random) {
  TriangleBoxCase c = oriented_grid(random);
  constexpr std::array<int, 5> kExponents{-1000, -500, -300, 300, 480};
  const int space = kExponents[random.index(5)], axis = kExponents[random.index(5)];
  OrientedBox& box = *c.oriented;
  for (int k = 0; k < 3; ++k) {
    for (Vec3d* v : corners(c.triangle)) (*v)[k] = std::ldexp((*v)[k], space);
    box.center[k] = std::ldexp(box.center[k], space);
    box.half[k] = std::ldexp(box.half[k], space + axis);
    for (Vec3d& a : box.axes) a[k] = std::ldexp(a[k], axis);
  }
  return c;
}

constexpr std::array<TriangleBoxFamily, 16> kFamilies{{
    {"ordinary", 2, ordinary},
    {"coarse_grid", 2, coarse_grid},
    {"corner_in_triangle", 4, corner_in_triangle},
    {"edge_on_edge", 4, edge_on_edge},
    {"corner_on_surface", 4, corner_on_surface},
    {"in_a_face", 2, in_a_face},
    {"slivers", 1, slivers},
    {"no_area", 1, no_area},
    {"open_boxes", 1, open_boxes},
    {"flat_boxes", 2, flat_boxes},
    {"shifted", 2, shifted},
    {"extreme_scales", 1, extreme_scales},
    {"any_bits", 1, any_bits},
    {"oriented", 2, oriented},
    {"oriented_grid", 2, oriented_grid},
    {"oriented_extremes", 1, oriented_extremes},
}};

}  // namespace

std::span<const TriangleBoxFamily> triangle_box_families() { return kFamilies; }

}  // namespace sightline::stress
