#pragma once
/// Scenes, rays into them, and all that an engine answers, as one hash.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/demo/demo.h"
#include "core/import/import.h"
#include "core/run/engine.h"
#include "tests/support/golden_hash.h"

namespace sightline::test {

inline constexpr std::size_t kRays = 6000;

inline SceneDescription description_of(const demo::DemoScene& demo_scene) {
  Result<SceneDescription> description = import_bytes(demo::write_glb(demo_scene), {});
  EXPECT_TRUE(description.ok());
  return std::move(*description);
}

inline std::shared_ptr<const Scene> scene_of(const demo::DemoScene& demo_scene) {
  return *Scene::build(description_of(demo_scene));
}

/// Rays at corners, at edges, along axes, from far away and at random: integer arithmetic and
/// correctly rounded operations only, so that they are the same everywhere.
inline RayBatch rays_into(const Scene& scene) {
  std::mt19937_64 random(11);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const Box3d& box = scene.bounds();
  const auto inside = [&] {
    return Vec3d{box.min.x + unit() * (box.max.x - box.min.x),
                 box.min.y + unit() * (box.max.y - box.min.y),
                 box.min.z + unit() * (box.max.z - box.min.z)};
  };
  RayBatch rays;
  while (rays.size() < kRays) {
    const auto instance =
        static_cast<std::uint32_t>(random() % scene.description().instances.size());
    const Mesh& mesh = *scene.description().meshes[scene.description().instances[instance].mesh];
    if (mesh.triangle_count() == 0) continue;  // of a removed node
    const WorldTriangle w = scene.world_triangle(
        {instance, static_cast<std::uint32_t>(random() % mesh.triangle_count())});
    Ray ray;
    ray.origin = inside();
    Vec3d target = inside();
    switch (rays.size() % 6) {
      case 0:
        target = w.v0;
        break;
      case 1:
        target = {(w.v0.x + w.v1.x) / 2, (w.v0.y + w.v1.y) / 2, (w.v0.z + w.v1.z) / 2};
        break;
      case 2:
        ray.tmin = -3;
        break;
      case 3:
        target = {ray.origin.x, ray.origin.y - 1, ray.origin.z};
        break;
      case 4:
        ray.tmax = 0.75;
        break;
      default:
        break;
    }
    ray.direction = {target.x - ray.origin.x, target.y - ray.origin.y, target.z - ray.origin.z};
    if (rays.size() % 6 == 5) {
      ray.origin = {ray.origin.x - 1e7 * ray.direction.x, ray.origin.y - 1e7 * ray.direction.y,
                    ray.origin.z - 1e7 * ray.direction.z};
    }
    RayBatch one;
    one.push_back(ray);
    RayFault fault;
    if (check_rays(one, fault)) rays.push_back(ray);
  }
  return rays;
}

template <class T>
std::uint64_t hash_column(const Column<T>& column) {
  return golden_hash(std::as_bytes(std::span(column)));
}

inline std::uint64_t combine(std::uint64_t a, std::uint64_t b) {
  return (a ^ b) * 0x100000001b3ull;
}

struct Answers {
  HitBatch closest;
  Column<std::uint8_t> any;
  Column<std::uint64_t> count, crossings;
  HitLists all;
  Column<HitDetail> details;

  std::uint64_t hash() const {
    std::uint64_t h = hash_column(closest.t);
    h = combine(h, hash_column(closest.instance));
    h = combine(h, hash_column(closest.triangle));
    h = combine(h, hash_column(any));
    h = combine(h, hash_column(count));
    h = combine(h, hash_column(crossings));
    h = combine(h, hash_column(all.first));
    h = combine(h, hash_column(all.hits.t));
    h = combine(h, hash_column(all.hits.triangle));
    for (const HitDetail& detail : details) {
      const double numbers[] = {detail.position.x, detail.position.y, detail.position.z,
                                detail.normal.x,   detail.normal.y,   detail.normal.z,
                                detail.u,          detail.v,          detail.front ? 1.0 : 0.0};
      h = combine(h, golden_hash(std::as_bytes(std::span(numbers))));
    }
    return h;
  }
};

inline Answers ask(const Engine& engine, const Scene& scene, const RayBatch& rays) {
  Answers answers;
  Column<std::uint64_t> totals;
  const Deadline never = Deadline::never();
  EXPECT_TRUE(engine.closest(scene, rays, never, answers.closest).ok());
  EXPECT_TRUE(engine.any(scene, rays, never, answers.any).ok());
  EXPECT_TRUE(engine.count(scene, rays, Crossings::kEvery, never, answers.count).ok());
  EXPECT_TRUE(engine.count(scene, rays, Crossings::kOnce, never, answers.crossings).ok());
  EXPECT_TRUE(
      engine.all(scene, rays, {Crossings::kEvery, 5, 1u << 24}, never, answers.all, totals).ok());
  EXPECT_TRUE(engine.details(scene, rays, answers.closest, never, answers.details).ok());
  return answers;
}

inline std::unique_ptr<Engine> engine_of(const std::string& kernel, int threads) {
  EngineOptions options;
  options.kernel = kernel;
  options.threads = threads;
  auto engine = Engine::create(options);
  EXPECT_TRUE(engine.ok());
  return std::move(*engine);
}

struct Golden {
  const char* name;
  demo::DemoScene (*make)();
  std::uint64_t hash;
};

inline const Golden kGolden[] = {
    {"town", [] { return demo::town(); }, 0x0d91058372b3a1b1},
    {"city", [] { return demo::city(20000); }, 0x400c1d30cc9b66d1},
    {"terrain", [] { return demo::terrain(20000); }, 0x3f5e18c687f2fff2},
    {"instances", [] { return demo::instances(50, 300); }, 0x132c42d41e1ad816},
};

}  // namespace sightline::test
