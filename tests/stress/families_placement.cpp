#include <cmath>

#include "core/base/infinity.h"
#include "core/demo/demo.h"
#include "tests/stress/aims.h"
#include "tests/stress/meshes.h"

namespace sightline::stress {
namespace {

MeshPointer small_ball(Random& random) {
  MeshMaker maker;
  maker.ball(random, {0, 0, 0}, 1, 10, 20, 0.05);
  return maker.finish();
}

void aim_everywhere(const Aim& aim, std::size_t count, RayBatch& rays) {
  Random& r = aim.random();
  while (rays.size() < count) {
    const Vec3d target = r.chance(0.35)  ? aim.corner()
                         : r.chance(0.5) ? aim.edge_point()
                                         : aim.inner_point();
    Ray ray = r.chance(0.5) ? aim.at(target, 0.3) : aim.exactly_at(target);
    if (r.chance(0.1)) ray.tmin = -kInf;
    rays.push_back(ray);
  }
}

template <class Placement>
Case placed(Random& random, std::size_t count, int copies, Placement&& placement) {
  SceneDescription scene = scene_of({small_ball(random), stacked_cubes(1)}, {});
  for (int i = 0; i < copies; ++i) place(scene, random.chance(0.7) ? 0 : 1, placement());
  Case result{std::move(scene), {}, true};
  aim_everywhere(Aim(result.scene, random), count, result.rays);
  return result;
}

Affine somewhere(Random& random, double reach) {
  const Vec3d p = random.point(-reach, reach);
  return translation(p.x, p.y, p.z);
}

Case sheared(Random& random, std::size_t count) {
  return placed(random, count, 12, [&] {
    Affine shear;
    shear.m[random.integer(0, 2)][random.integer(0, 2)] += random.between(-1, 1) * 1e4;
    return somewhere(random, 10) * (rotation(random) * (shear * rotation(random)));
  });
}

Case mirrored(Random& random, std::size_t count) {
  return placed(random, count, 25, [&] {
    const Affine mirror = scaling(random.chance(0.5) ? -1 : 1, random.chance(0.5) ? -1.5 : 1,
                                  random.chance(0.5) ? -0.5 : 1);
    return somewhere(random, 4) * (random.chance(0.5) ? mirror : rotation(random) * mirror);
  });
}

Case flattened(Random& random, std::size_t count) {
  return placed(random, count, 12, [&] {
    const double thin = random.chance(0.5) ? 0 : std::pow(10, random.between(-300, -3));
    const Affine flat = scaling(1, thin, random.chance(0.2) ? thin : 1);
    return somewhere(random, 3) * (random.chance(0.5) ? flat : rotation(random) * flat);
  });
}

Case many_rotated(Random& random, std::size_t count) {
  return placed(random, count, 150, [&] {
    const double s = random.between(0.5, 1.5);
    return somewhere(random, 12) * (rotation(random) * scaling(s, s, s * random.between(0.5, 2)));
  });
}

Case flush(Random& random, std::size_t count) {
  // Placed cubes whose faces lie in one another: hits of several placements at the same t.
  SceneDescription scene = scene_of({stacked_cubes(1), stacked_cubes(2)}, {});
  for (int i = 0; i < 40; ++i) {
    Affine at = translation(random.integer(-3, 3), random.integer(-3, 3), random.integer(-3, 3));
    const double s = random.chance(0.5) ? 1 : random.chance(0.5) ? 2 : -1;
    place(scene, random.chance(0.7) ? 0 : 1, at * scaling(s, s, s));
  }
  Case result{std::move(scene), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    Ray ray;
    for (int k = 0; k < 3; ++k) {
      ray.origin[k] = 0.25 * random.integer(-24, 24);
      ray.direction[k] = random.integer(-2, 2);
    }
    if (random.chance(0.3)) ray = aim.exactly_at(aim.inner_point());
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

Case far_shift(Random& random, std::size_t count) {
  // Two copies 1e8 apart: the coordinates of one are coarse beside those of the other.
  SceneDescription scene = scene_of({scan(random, 3000)}, {Affine{}, translation(1e8, 1e8, -1e8)});
  Case result{std::move(scene), {}, true};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    const Vec3d origin = random.chance(0.5) ? plus(aim.corner(), 3, random.direction())
                                            : as_float32(plus(aim.corner(), 3, random.direction()));
    Ray ray{origin, minus(random.chance(0.5) ? aim.corner() : aim.edge_point(), origin)};
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

/// A demo scene's meshes as they are, placed once.
SceneDescription from_demo(const demo::DemoScene& source) {
  SceneDescription scene;
  for (const demo::DemoMesh& mesh : source.meshes) {
    MeshMaker maker;
    for (std::size_t i = 0; i + 2 < mesh.positions.size(); i += 3)
      maker.corner(static_cast<double>(mesh.positions[i]),
                   static_cast<double>(mesh.positions[i + 1]),
                   static_cast<double>(mesh.positions[i + 2]));
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
      maker.triangle(mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]);
    scene.meshes.push_back(maker.finish());
    place(scene, static_cast<std::uint32_t>(scene.meshes.size() - 1), Affine{});
  }
  return scene;
}

Case city(Random& random, std::size_t count) {
  Case result{from_demo(demo::city(20000, random.bits())), {}, false};
  const Aim aim(result.scene, random);
  Vec3d eye;
  for (std::size_t i = 0; i < count; ++i) {
    // A LiDAR turns at a place; its beams are float32.
    if (i % 2048 == 0) eye = as_float32(aim.around(0));
    const double turn = 6.283185307179586 * static_cast<double>(i % 2048) / 2048;
    const double tilt = 0.4 * random.integer(-16, 8) / 16;
    result.rays.push_back({eye, as_float32({std::cos(turn), std::sin(tilt), std::sin(turn)})});
  }
  return result;
}

Case terrain(Random& random, std::size_t count) {
  Case result{from_demo(demo::terrain(20000, random.bits())), {}, false};
  const Aim aim(result.scene, random);
  while (result.rays.size() < count) {
    // Flat over the hills, or straight down on grid points.
    Ray ray = aim.exactly_at(aim.corner());
    if (random.chance(0.5)) {
      ray.origin = as_float32(aim.around(0));
      ray.direction =
          as_float32({random.between(-1, 1), random.between(-0.02, 0.02), random.between(-1, 1)});
    } else if (random.chance(0.5)) {
      ray.origin = aim.random().chance(0.5) ? aim.corner() : aim.edge_point();
      ray.origin.y = aim.box().max.y + 1;
      ray.direction = {0, -1, 0};
    }
    ensure_valid(ray);
    result.rays.push_back(ray);
  }
  return result;
}

}  // namespace

std::vector<Family> placement_families() {
  return {
      {"shear_1e4", "placements with a shear of condition 1e4", sheared},
      {"mirrored_placements", "placements with negative scales", mirrored},
      {"flattened_placements", "one or two axes scaled to nothing or nearly nothing", flattened},
      {"many_rotated_placements", "150 rotated and scaled copies", many_rotated},
      {"flush_placements", "placed cubes with faces in one another", flush},
      {"copies_1e8_apart", "two copies with 1e8 between them", far_shift},
      {"city_lidar", "LiDAR in a city of very different sizes", city},
      {"terrain_flat_and_down", "flat rays over hills, vertical rays on grid points", terrain},
  };
}

}  // namespace sightline::stress
