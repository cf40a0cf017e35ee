// The same bytes from every kernel, number of threads, order and size of batch: one hash per scene,
// written down here, so that any machine can tell.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <random>

#include "core/demo/demo.h"
#include "core/import/import.h"
#include "core/run/engine.h"
#include "tests/support/golden_hash.h"

namespace sightline {
namespace {

constexpr std::size_t kRays = 6000;

std::shared_ptr<const Scene> scene_of(const demo::DemoScene& demo_scene) {
  Result<SceneDescription> description = import_bytes(demo::write_glb(demo_scene), {});
  EXPECT_TRUE(description.ok());
  return *Scene::build(std::move(*description));
}

/// Rays at corners, at edges, along axes, from far away and at random: integer arithmetic and
/// correctly rounded operations only, so that they are the same everywhere.
RayBatch rays_into(const Scene& scene) {
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
  return test::golden_hash(std::as_bytes(std::span(column)));
}

std::uint64_t combine(std::uint64_t a, std::uint64_t b) { return (a ^ b) * 0x100000001b3ull; }

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
      h = combine(h, test::golden_hash(std::as_bytes(std::span(numbers))));
    }
    return h;
  }
};

Answers ask(const Engine& engine, const Scene& scene, const RayBatch& rays) {
  Answers answers;
  Column<std::uint64_t> totals;
  const Deadline never = Deadline::never();
  EXPECT_TRUE(engine.closest(scene, rays, never, answers.closest).ok());
  EXPECT_TRUE(engine.any(scene, rays, never, answers.any).ok());
  EXPECT_TRUE(engine.count(scene, rays, Crossings::kEvery, never, answers.count).ok());
  EXPECT_TRUE(engine.count(scene, rays, Crossings::kOnce, never, answers.crossings).ok());
  EXPECT_TRUE(
      engine.all(scene, rays, Crossings::kEvery, 5, 1u << 24, never, answers.all, totals).ok());
  EXPECT_TRUE(engine.details(scene, rays, answers.closest, never, answers.details).ok());
  return answers;
}

std::unique_ptr<Engine> engine_of(const std::string& kernel, int threads) {
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

const Golden kGolden[] = {
    {"town", [] { return demo::town(); }, 0x0d91058372b3a1b1},
    {"city", [] { return demo::city(20000); }, 0x400c1d30cc9b66d1},
    {"terrain", [] { return demo::terrain(20000); }, 0x3f5e18c687f2fff2},
    {"instances", [] { return demo::instances(50, 300); }, 0x132c42d41e1ad816},
};

TEST(Golden, every_kernel_and_number_of_threads_gives_the_same_bytes) {
  for (const Golden& golden : kGolden) {
    const auto scene = scene_of(golden.make());
    const RayBatch rays = rays_into(*scene);
    for (const std::string& kernel : Engine::kernels()) {
      for (const int threads : {1, 2}) {
        const std::uint64_t hash = ask(*engine_of(kernel, threads), *scene, rays).hash();
        EXPECT_EQ(hash, golden.hash)
            << golden.name << ", " << kernel << ", " << threads << " threads";
        std::printf("%-10s %-9s %d threads 0x%016llx\n", golden.name, kernel.c_str(), threads,
                    static_cast<unsigned long long>(hash));
      }
    }
  }
}

TEST(Golden, order_and_size_of_a_batch_change_no_byte) {
  for (const Golden& golden : kGolden) {
    const auto scene = scene_of(golden.make());
    const RayBatch rays = rays_into(*scene);
    const auto engine = engine_of("", 2);
    const Answers whole = ask(*engine, *scene, rays);

    std::vector<std::size_t> order(rays.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937_64(3));
    RayBatch shuffled;
    for (const std::size_t i : order) shuffled.push_back(rays[i]);
    const Answers other = ask(*engine, *scene, shuffled);
    for (std::size_t k = 0; k < order.size(); ++k) {
      ASSERT_EQ(other.closest.id(k), whole.closest.id(order[k])) << golden.name;
      ASSERT_EQ(std::bit_cast<std::uint64_t>(other.closest.t[k]),
                std::bit_cast<std::uint64_t>(whole.closest.t[order[k]]))
          << golden.name;
      ASSERT_EQ(other.any[k], whole.any[order[k]]) << golden.name;
      ASSERT_EQ(other.count[k], whole.count[order[k]]) << golden.name;
      ASSERT_EQ(other.crossings[k], whole.crossings[order[k]]) << golden.name;
    }

    for (std::size_t i = 0; i < rays.size(); i += 7) {
      RayBatch single;
      single.push_back(rays[i]);
      HitBatch hits;
      Column<std::uint8_t> any;
      ASSERT_TRUE(engine->closest(*scene, single, Deadline::never(), hits).ok());
      ASSERT_TRUE(engine->any(*scene, single, Deadline::never(), any).ok());
      ASSERT_EQ(hits.id(0), whole.closest.id(i)) << golden.name;
      ASSERT_EQ(std::bit_cast<std::uint64_t>(hits.t[0]),
                std::bit_cast<std::uint64_t>(whole.closest.t[i]))
          << golden.name;
      ASSERT_EQ(any[0], whole.any[i]) << golden.name;
    }
  }
}

}  // namespace
}  // namespace sightline
