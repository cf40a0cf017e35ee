#include <cmath>

#include "core/base/infinity.h"
#include "tests/oracle/rational.h"
#include "tests/stress/aims.h"
#include "tests/stress/meshes.h"

namespace sightline::stress {
namespace {

Case incoherent(Random& random, std::size_t count) {
  Case result{scene_of(soup(random, 8000, 40)), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray{as_float32(aim.around(0)), as_float32(random.direction())};
    if (random.chance(0.2)) ray.tmax = 5 * random.unit();
    result.rays.push_back(ray);
  }
  return result;
}

Case on_faces_and_corners(Random& random, std::size_t count) {
  Case result{scene_of(stacked_cubes(5)), {}, true};
  while (result.rays.size() < count) {
    Ray ray;
    for (int k = 0; k < 3; ++k) {
      ray.origin[k] = random.chance(0.6) ? random.integer(0, 5) : 0.125 * random.integer(0, 40);
      ray.direction[k] = random.integer(-3, 3);
    }
    ray.tmin = random.chance(0.2) ? -kInf : random.chance(0.2) ? random.integer(-2, 2) : 0;
    ray.tmax = random.chance(0.2) ? std::max(ray.tmin, 0.0) + random.integer(0, 2) : kInf;
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case duplicates(Random& random, std::size_t count) {
  MeshMaker maker;
  for (int i = 0; i < 400; ++i) {
    const Vec3d a = random.point(-5, 5), b = random.point(-5, 5), c = random.point(-5, 5);
    const std::uint32_t v = maker.corner(a);
    maker.corner(b);
    maker.corner(c);
    maker.triangle(v, v + 1, v + 2);
    for (int copy = random.integer(0, 4); copy > 0; --copy) {
      const auto turn = static_cast<std::uint32_t>(random.index(3));
      const std::uint32_t p = v + turn, q = v + (turn + 1) % 3, s = v + (turn + 2) % 3;
      if (random.chance(0.5)) {
        maker.triangle(p, q, s);
      } else {
        maker.triangle(q, p, s);
      }
    }
    if (random.chance(0.3)) maker.triangle(a, c, b);  // the same place, other corners
  }
  Case result{scene_of(maker.finish()), {}, false};
  if (random.chance(0.5)) place(result.scene, 0, Affine{});  // and the whole mesh twice
  const Aim aim(result.scene, random);
  while (result.rays.size() < count)
    result.rays.push_back(random.chance(0.5) ? aim.exactly_at(aim.inner_point())
                                             : aim.at(aim.edge_point()));
  return result;
}

Case degenerate(Random& random, std::size_t count) {
  // Without area, nearly without area, and sound ones that share their corners.
  MeshMaker maker;
  for (int i = 0; i < 800; ++i) {
    Vec3d a, d;
    for (int k = 0; k < 3; ++k) {
      a[k] = 0.25 * random.integer(-12, 12);
      d[k] = 0.25 * random.integer(-8, 8);
    }
    const Vec3d b = plus(a, 1, d);
    const Vec3d c = plus(a, random.integer(-2, 3), d);
    const std::uint32_t v = maker.corner(a);
    maker.corner(b);
    maker.corner(random.chance(0.5) ? c : nudged(random, c, 0));
    Vec3d near = c;
    near[random.integer(0, 2)] =
        static_cast<double>(std::nextafter(static_cast<float>(c.x), 99.0F));
    maker.corner(near);
    maker.corner(random.point(-3, 3));
    maker.triangle(v, v + 1, v + 2);
    maker.triangle(v, v, v + 1);
    maker.triangle(v, v + 1, v + 3);
    maker.triangle(v, v + 1, v + 4);
  }
  Case result{scene_of(maker.finish()), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    const Vec3d target = random.chance(0.4) ? aim.corner() : aim.edge_point();
    Ray ray = aim.exactly_at(target);
    if (random.chance(0.2)) {
      const auto v = corners(aim.triangle());
      ray = {plus(v[0], -2, minus(v[1], v[0])), minus(v[1], v[0])};  // along an edge
    }
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case box_edges(Random& random, std::size_t count) {
  Case result{scene_of(stacked_cubes(4)), {}, true};
  while (result.rays.size() < count) {
    Ray ray;
    if (random.chance(0.5)) {  // along an edge
      const int axis = random.integer(0, 2);
      for (int k = 0; k < 3; ++k) ray.origin[k] = random.integer(0, 4);
      ray.origin[axis] = 0.25 * random.integer(-8, 24);
      ray.direction[axis] = random.chance(0.5) ? 1 : -0.3;
    } else {  // through a corner, from a lattice point
      Vec3d target;
      for (int k = 0; k < 3; ++k) {
        target[k] = random.integer(0, 4);
        ray.direction[k] = random.integer(-4, 4);
      }
      ray.origin = plus(target, -random.integer(1, 3), ray.direction);
    }
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case small_grid(Random& random, std::size_t count) {
  MeshMaker maker;
  const auto lattice = [&](int reach) {
    const double x = random.integer(-reach, reach), y = random.integer(-reach, reach);
    return Vec3d{x, y, static_cast<double>(random.integer(-reach, reach))};
  };
  for (int i = 0; i < 120; ++i) maker.triangle(lattice(3), lattice(3), lattice(3));
  Case result{scene_of(maker.finish()), {}, false};
  while (result.rays.size() < count) {
    Ray ray{lattice(5), lattice(3)};
    if (random.chance(0.2)) ray.tmin = random.chance(0.5) ? -kInf : random.integer(-2, 2);
    if (random.chance(0.2)) ray.tmax = std::max(ray.tmin, 0.0) + random.integer(0, 3);
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case whole_lines(Random& random, std::size_t count) {
  Case result{scene_of(scan(random, 5000)), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray = random.chance(0.5) ? aim.exactly_at(aim.corner()) : aim.at(aim.edge_point());
    ray.tmin = random.chance(0.5) ? -kInf : -5 * random.unit();
    if (random.chance(0.3)) ray.tmax = random.chance(0.5) ? 0 : ray.tmin;
    if (!(ray.tmin <= ray.tmax)) ray.tmax = kInf;
    if (std::isinf(ray.tmax) && ray.tmax < 0) ray.tmax = 0;
    result.rays.push_back(ray);
  }
  return result;
}

Case fan(Random& random, std::size_t count) {
  // Hundreds of triangles around one corner: all of them meet a ray through it.
  MeshMaker maker;
  const int n = random.integer(100, 400);
  const std::uint32_t tip = maker.corner(random.point(-0.1, 0.1));
  const auto rim = tip + 1;
  for (int i = 0; i < n; ++i) {
    const double a = 6.283185307179586 * i / n;
    maker.corner(std::cos(a), std::sin(a), random.between(-0.4, 0.4));
  }
  for (int i = 0; i < n; ++i)
    maker.triangle(tip, rim + static_cast<std::uint32_t>(i),
                   rim + static_cast<std::uint32_t>((i + 1) % n));
  Case result{scene_of(maker.finish()), {}, false};
  const Aim aim(result.scene, random);
  const Vec3d middle = aim.triangles()[0].v0;
  while (result.rays.size() < count) {
    Ray ray = random.chance(0.5) ? aim.exactly_at(middle) : aim.exactly_at(aim.edge_point());
    if (random.chance(0.2)) ray.direction = nudged(random, ray.direction, 1);
    result.rays.push_back(ray);
  }
  return result;
}

Case a_hair_from_surface(Random& random, std::size_t count) {
  Case result{scene_of(scan(random, 5000)), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    const Vec3d origin = nudged(random, random.chance(0.5) ? aim.corner() : aim.inner_point(), 2);
    Ray ray{origin, random.chance(0.5) ? random.direction() : minus(aim.corner(), origin)};
    if (random.chance(0.2)) ray.tmin = 0x1p-60;
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case limits_in_plane(Random& random, std::size_t count) {
  // Axis-aligned sheets of triangles: rays in the sheet start, end and turn inside of it.
  MeshMaker maker;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      const double x = i, y = j;
      maker.triangle({x, y, 0}, {x + 1, y, 0}, {x, y + 1, 0});
      maker.triangle({x + 1, y + 1, 0}, {x, y + 1, 0}, {x + 1, y, 0});
      maker.triangle({x, 2, y}, {x + 1, 2, y}, {x, 2, y + 1});
    }
  }
  Case result{scene_of(maker.finish()), {}, false};
  while (result.rays.size() < count) {
    Ray ray;
    ray.origin = {0.25 * random.integer(-8, 40), 0.25 * random.integer(-8, 40), 0};
    ray.direction = {0.5 * random.integer(-4, 4), 0.5 * random.integer(-4, 4), 0};
    if (random.chance(0.3)) {
      std::swap(ray.origin.y, ray.origin.z);
      std::swap(ray.direction.y, ray.direction.z);
      ray.origin.y = 2;
    }
    if (random.chance(0.5)) ray.tmin = random.chance(0.2) ? -kInf : 0.1 * random.integer(-10, 30);
    if (random.chance(0.5)) ray.tmax = std::max(ray.tmin, -9.0) + 0.1 * random.integer(0, 20);
    if (!(ray.tmin <= ray.tmax)) ray.tmax = kInf;
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case signed_zeros(Random& random, std::size_t count) {
  Case result{scene_of(stacked_cubes(3)), {}, true};
  const Affine middle = translation(-1.5, -1.5, -1.5);
  place(result.scene, 0, middle);
  while (result.rays.size() < count) {
    const auto number = [&] {
      return random.chance(0.5) ? (random.chance(0.5) ? 0.0 : -0.0) : 0.5 * random.integer(-6, 6);
    };
    Ray ray{{number(), number(), number()}, {number(), number(), number()}};
    if (random.chance(0.3)) ray.tmin = random.chance(0.5) ? -0.0 : -1;
    if (random.chance(0.2)) ray.tmax = ray.tmin > 0 ? kInf : (random.chance(0.5) ? 0.0 : -0.0);
    if (!(ray.tmin <= ray.tmax)) ray.tmax = kInf;
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

}  // namespace

std::vector<Family> contact_families() {
  return {
      {"incoherent", "random rays in a soup of triangles", incoherent},
      {"origin_on_faces_and_corners",
       "lattice rays that start on faces, edges and corners of cubes", on_faces_and_corners},
      {"duplicate_triangles", "each triangle up to ten times, turned and mirrored", duplicates},
      {"degenerate_triangles", "triangles without area or nearly so, aims at their corners",
       degenerate},
      {"box_edges_and_corners", "rays along edges and through corners of stacked cubes", box_edges},
      {"small_integer_grid", "triangles and rays of integers from -5 to 5", small_grid},
      {"whole_lines", "negative and infinite tmin", whole_lines},
      {"fan_of_hundreds", "a corner that hundreds of triangles share", fan},
      {"a_hair_from_the_surface", "the origin two numbers off the surface", a_hair_from_surface},
      {"limits_in_the_plane", "rays in the plane whose limits lie on the triangles",
       limits_in_plane},
      {"signed_zeros", "zeros of both signs in origins, directions and limits", signed_zeros},
  };
}

}  // namespace sightline::stress
