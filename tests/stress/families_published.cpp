#include <cmath>
#include <limits>

#include "tests/stress/aims.h"
#include "tests/stress/meshes.h"

// The data files of the threads are not public any more or were not to be had; what is rebuilt here
// is the situation that each thread describes in words and numbers.

namespace sightline::stress {
namespace {

/// RenderKit/embree #174 "Ray fails to intersect with watertight surface": a watertight half
/// sphere, rays cast exactly at its vertices, robust flag set, no intersection recorded.
Case embree_174(Random& random, std::size_t count) {
  MeshMaker maker;
  constexpr int kRows = 24, kColumns = 48;
  constexpr double kPi = 3.141592653589793;
  const double radius = random.between(1, 50);
  const Vec3d center = random.point(-20, 20);
  const std::uint32_t top = maker.corner(plus(center, radius, {0, 0, 1}));
  for (int i = 1; i <= kRows; ++i) {
    for (int j = 0; j < kColumns; ++j) {
      const double a = 0.5 * kPi * i / kRows, b = 2 * kPi * j / kColumns;
      maker.corner(plus(center, radius,
                        {std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)}));
    }
  }
  const std::uint32_t foot = maker.corner(center);
  const auto at = [&](int i, int j) {
    return i == 0 ? top
                  : top + 1 + static_cast<std::uint32_t>(i - 1) * kColumns +
                        static_cast<std::uint32_t>(j % kColumns);
  };
  for (int j = 0; j < kColumns; ++j) {
    for (int i = 0; i < kRows; ++i) {
      if (i > 0) maker.triangle(at(i, j), at(i + 1, j), at(i, j + 1));
      maker.triangle(at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
    }
    maker.triangle(foot, at(kRows, j + 1), at(kRows, j));
  }
  Case result{scene_of(maker.finish()), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) result.rays.push_back(aim.exactly_at(aim.corner()));
  return result;
}

/// RenderKit/embree #181 "In robust mode a ray can fail to hit a triangle mesh": ten nested
/// cylinders like Russian dolls, a ray that starts between two of them hits the next one exactly at
/// a vertex; with one more cylinder outside, it passes through.
Case embree_181(Random& random, std::size_t count) {
  MeshMaker maker;
  constexpr std::uint32_t kColumns = 32;
  constexpr double kPi = 3.141592653589793;
  const int cylinders = random.integer(10, 11);
  for (int c = 1; c <= cylinders; ++c) {
    const double radius = 10.0 * c;
    std::uint32_t first = 0;
    for (std::uint32_t j = 0; j < kColumns; ++j) {
      const double b = 2 * kPi * j / kColumns;
      const std::uint32_t v = maker.corner(radius * std::cos(b), radius * std::sin(b), -50.0 - c);
      if (j == 0) first = v;
      maker.corner(radius * std::cos(b), radius * std::sin(b), 50.0 + c);
    }
    const std::uint32_t low = maker.corner(0, 0, -50.0 - c);
    const std::uint32_t high = maker.corner(0, 0, 50.0 + c);
    for (std::uint32_t j = 0; j < kColumns; ++j) {
      const std::uint32_t a = first + 2 * j, b = first + 2 * ((j + 1) % kColumns);
      maker.triangle(a, b, a + 1);
      maker.triangle(b, b + 1, a + 1);
      maker.triangle(low, b, a);
      maker.triangle(high, a + 1, b + 1);
    }
  }
  Case result{scene_of(maker.finish()), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    const Vec3d target = random.chance(0.7) ? aim.corner() : aim.edge_point();
    // From between two cylinders, outwards through the vertex.
    const double inner = random.between(0.5, 0.95);
    const Vec3d origin = as_float32({inner * target.x, inner * target.y,
                                     random.chance(0.5) ? target.z : random.between(-50, 50)});
    Ray ray{origin, as_float32(minus(target, origin))};
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

/// RenderKit/embree #387 "Incorrect intersection results when using RTC_SCENE_FLAG_ROBUST": one
/// skinny triangle with edges of about 11.2, 9.7 and 1.4, a ray about 0.52 degrees from its plane
/// that starts within 600 of it and does not meet it; a hit at t = 12291 is reported.
Case embree_387(Random& random, std::size_t count) {
  MeshMaker maker;
  const Vec3d at = random.point(-400, 400);
  for (int i = 0; i < 30; ++i) {
    const Vec3d along = random.direction();
    Vec3d across = cross(along, random.direction());
    across = scaled(across, 1 / length(across));
    const Vec3d a = plus(at, 20, random.point(-1, 1));
    // The corner that makes edges 11.2 and 1.4 from the ends of 9.7 is nearly on the line.
    maker.triangle(a, plus(a, 9.7, along), plus(plus(a, 11.0, along), 0.45, across));
  }
  Case result{scene_of(maker.finish()), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    const Triangle& w = aim.triangle();
    const Vec3d normal = cross(minus(w.v1, w.v0), minus(w.v2, w.v0));
    const Vec3d target = point_of(w, random.between(-1, 2), random.between(-1, 2));
    Vec3d along = minus(point_of(w, random.between(-1, 1), random.between(-1, 1)), w.v0);
    along = scaled(along, 1 / length(along));
    const double slope = std::tan(random.between(0.0, 1.0) * 3.141592653589793 / 180);
    const Vec3d direction = plus(along, slope / length(normal), normal);
    Ray ray{as_float32(plus(target, -random.between(100, 600), direction)), as_float32(direction)};
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

/// RenderKit/embree #423 "Intersection between triangle and ray that shouldn't happen": collisions
/// of meshes, each edge of one as a ray from one end (tnear 0) to the other (tfar 1) against the
/// triangles of the other; a hit is reported between an edge and a triangle far from each other.
Case embree_423(Random& random, std::size_t count) {
  MeshMaker maker;
  maker.ball(random, {0.2, 1.3, 0.1}, 0.25, 24, 48, 0.03);
  const MeshPointer body = maker.finish();
  MeshMaker other;
  other.ball(random, {0.35, 1.45, 0.05}, 0.2, 24, 48, 0.05);
  const std::vector<Triangle> edges = world(scene_of(other.finish()));
  Case result{scene_of(body), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    const auto v = corners(edges[random.index(edges.size())]);
    const std::size_t i = random.index(3);
    Ray ray{v[i], minus(v[(i + 1) % 3], v[i]), 0, 1};
    if (random.chance(0.3)) ray.direction = as_float32(ray.direction);
    if (random.chance(0.2)) {
      // An edge of the mesh itself: it touches its own triangles along their whole length.
      const auto own = corners(aim.triangle());
      ray = {own[0], minus(own[1], own[0]), 0, 1};
    }
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

/// RenderKit/embree #188 "There is no way to gather all intersections on a ray in a robust manner":
/// exact edge hits on a closed mesh, all hits wanted, each crossing once.
Case embree_188(Random& random, std::size_t count) {
  MeshMaker maker;
  maker.ball(random, {0, 0, 0}, 2, 16, 32, 0.0);
  maker.ball(random, {0, 0, 0}, 1, 12, 24, 0.1);
  Case result{scene_of(maker.finish()), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray = aim.exactly_at(random.chance(0.6) ? aim.edge_point() : aim.corner());
    if (random.chance(0.3)) ray = {{0, 0, 0}, aim.corner()};  // out of the middle, at a vertex
    result.rays.push_back(ray);
  }
  return result;
}

/// RenderKit/embree #298 "no intersection reported between primitive and ray if they are planar":
/// triangle (0,0,0) (1,0,0) (0,1,0), origin (-1,0.5,0), direction (1,0,0).
Case embree_298(Random& random, std::size_t count) {
  MeshMaker maker;
  maker.triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (int i = 1; i < 20; ++i) {
    const double x = 0.5 * random.integer(-6, 6), y = 0.5 * random.integer(-6, 6);
    maker.triangle({x, y, 0}, {x + 1, y, 0}, {x, y + 1, 0});
  }
  Case result{scene_of(maker.finish()), {}, false};
  result.rays.push_back({{-1, 0.5, 0}, {1, 0, 0}});
  while (result.rays.size() < count) {
    Ray ray{{0.25 * random.integer(-20, 20), 0.25 * random.integer(-20, 20), 0},
            {0.25 * random.integer(-4, 4), 0.25 * random.integer(-4, 4), 0}};
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

}  // namespace

std::vector<Family> published_families() {
  return {
      {"embree_174_half_sphere", "watertight half sphere, rays at its vertices", embree_174},
      {"embree_181_nested_cylinders", "nested cylinders, rays outwards through their vertices",
       embree_181},
      {"embree_387_skinny_triangle", "rays within a degree of the plane of skinny triangles",
       embree_387},
      {"embree_423_edges_as_rays", "edges of one mesh as rays with tmax = 1 against another",
       embree_423},
      {"embree_188_all_hits", "edges and vertices of nested balls, all hits", embree_188},
      {"embree_298_in_the_plane", "lattice rays in the plane of triangles", embree_298},
  };
}

std::vector<Family> families() {
  std::vector<Family> all;
  for (auto part : {contract_families(), contact_families(), magnitude_families(),
                    placement_families(), neighbour_families(), published_families()})
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace sightline::stress
