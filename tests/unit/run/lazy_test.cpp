// Trees that are built when rays come near: the same bytes, and no more trees than were needed.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <thread>

#include "core/base/infinity.h"
#include "core/query/sweep_batch.h"
#include "core/trace/kernel/kernel.h"
#include "core/trace/search/unbuilt.h"
#include "tests/unit/run/golden_answers.h"

namespace sightline {
namespace {

using test::ask;
using test::description_of;
using test::engine_of;
using test::rays_into;

std::shared_ptr<const Scene> lazy_scene_of(const demo::DemoScene& scene) {
  return *Scene::prepare(description_of(scene));
}

/// `side` times `side` small boxes with a mesh of its own each, one unit apart in the plane z = 0.
demo::DemoScene boxes_apart(std::uint32_t side) {
  demo::DemoScene scene;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    demo::DemoMesh mesh;
    const auto height = static_cast<float>(0.1 + 0.0001 * i);  // no two have the same content
    for (const float z : {0.0f, height}) {
      for (const float y : {0.0f, 0.5f}) {
        for (const float x : {0.0f, 0.5f}) {
          mesh.positions.insert(mesh.positions.end(), {x, y, z});
        }
      }
    }
    mesh.indices = {0, 1, 2, 1, 3, 2, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                    2, 3, 6, 3, 7, 6, 0, 2, 4, 2, 6, 4, 1, 3, 5, 3, 7, 5};
    demo::DemoNode node;
    node.mesh = static_cast<int>(i);
    node.parent_from_node.m[0][3] = i % side;
    const auto row = i / side;
    node.parent_from_node.m[1][3] = row;
    scene.meshes.push_back(std::move(mesh));
    scene.nodes.push_back(std::move(node));
  }
  return scene;
}

RayBatch one_ray(const Vec3d& origin, const Vec3d& direction) {
  RayBatch rays;
  rays.push_back({origin, direction});
  return rays;
}

BoxBatch boxes_within(const Scene& scene, std::size_t count) {
  std::mt19937_64 random(5);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  BoxBatch boxes;
  while (boxes.size() < count) {
    Vec3d at, far;
    for (int k = 0; k < 3; ++k) {
      const double width = scene.bounds().max[k] - scene.bounds().min[k];
      at[k] = scene.bounds().min[k] + unit() * width;
      far[k] = at[k] + unit() * width / 20;
    }
    const std::array<HalfSpace, 4> wedge{{{{1, 0, 0}, far.x},
                                          {{-1, 0.5, 0}, -at.x + 0.5 * far.y},
                                          {{0, 0, 1}, far.z},
                                          {{0, 0, -1}, -at.z}}};
    switch (boxes.size() % 4) {
      case 0:
        boxes.push_back(Box3d{at, far});
        break;
      case 1:
        boxes.push_back(OrientedBox{at, {far.x - at.x, 0.5, 2}, rotated_axes(0, 0.6, 0, 0.8)});
        break;
      case 2:
        boxes.push_back(Capsule{at, far, 1.5});
        break;
      default:
        boxes.push_back(ConvexRegion{wedge});
    }
  }
  return boxes;
}

TEST(LazyScene, answers_the_golden_bytes) {
  for (const test::Golden& golden : test::kGolden) {
    const auto scene = lazy_scene_of(golden.make());
    EXPECT_FALSE(scene->tree()->complete());
    const RayBatch rays = rays_into(*scene);
    EXPECT_EQ(ask(*engine_of("", 2), *scene, rays).hash(), golden.hash) << golden.name;
    EXPECT_GT(scene->trees().stats().trees_built, 0u);
  }
}

TEST(LazyScene, answers_every_kind_of_question_first_as_it_does_last) {
  const auto make = [] { return demo::town(); };
  const auto whole = test::scene_of(make());
  const RayBatch rays = rays_into(*whole);
  const BoxBatch boxes = boxes_within(*whole, 100);
  const auto engine = engine_of("", 2);
  const Deadline never = Deadline::never();
  Column<std::uint8_t> any, lazy_any;
  ASSERT_TRUE(engine->any(*whole, rays, never, any));
  ASSERT_TRUE(engine->any(*lazy_scene_of(make()), rays, never, lazy_any));
  EXPECT_EQ(any, lazy_any);
  Column<std::uint64_t> count, lazy_count;
  ASSERT_TRUE(engine->count(*whole, rays, Crossings::kEvery, never, count));
  ASSERT_TRUE(engine->count(*lazy_scene_of(make()), rays, Crossings::kEvery, never, lazy_count));
  EXPECT_EQ(count, lazy_count);
  ASSERT_TRUE(engine->boxes_any(*whole, boxes, never, any));
  ASSERT_TRUE(engine->boxes_any(*lazy_scene_of(make()), boxes, never, lazy_any));
  EXPECT_EQ(any, lazy_any);
  for (const BoxTargets targets : {BoxTargets::kTriangles, BoxTargets::kNodes}) {
    BoxLists lists, lazy_lists;
    ASSERT_TRUE(engine->boxes_list(*whole, boxes, targets, {50, 1u << 20}, never, lists, count));
    ASSERT_TRUE(engine->boxes_list(*lazy_scene_of(make()), boxes, targets, {50, 1u << 20}, never,
                                   lazy_lists, lazy_count));
    EXPECT_EQ(count, lazy_count);
    EXPECT_EQ(lists.first, lazy_lists.first);
    EXPECT_EQ(lists.triangles, lazy_lists.triangles);
    EXPECT_EQ(lists.nodes, lazy_lists.nodes);
  }
}

TEST(LazyScene, is_swept_through_as_a_whole_one_is) {
  const auto make = [] { return demo::town(); };
  const auto whole = test::scene_of(make());
  const RayBatch rays = rays_into(*whole);
  SweepBatch sweeps;
  for (std::size_t i = 0; i < std::min<std::size_t>(rays.size(), 200); ++i) {
    if (i % 2 == 0) {
      sweeps.push_back_sphere(rays[i], 0.5 + 0.01 * static_cast<double>(i));
    } else {
      sweeps.push_back(rays[i], SweptBox{{1, 0.25, 0.5}});
    }
  }
  const Deadline never = Deadline::never();
  HitBatch hits, lazy_hits;
  ASSERT_TRUE(engine_of("", 1)->sweep(*whole, sweeps, false, never, hits));
  ASSERT_TRUE(engine_of("", 3)->sweep(*lazy_scene_of(make()), sweeps, false, never, lazy_hits));
  EXPECT_EQ(hits.t, lazy_hits.t);
  EXPECT_EQ(hits.instance, lazy_hits.instance);
  EXPECT_EQ(hits.triangle, lazy_hits.triangle);
  std::size_t met = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) met += hits.hit(i) ? 1u : 0u;
  EXPECT_GT(met, 50u);
  CancelFlag flag;
  flag.cancel();
  const Deadline passed = Deadline::in(std::chrono::hours(1), &flag);
  const Status late = engine_of("", 1)->sweep(*whole, sweeps, false, passed, hits);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().kind, ErrorKind::kCancelled);
}

TEST(LazyScene, builds_what_is_near_a_point_and_finds_what_is_nearest) {
  const auto lazy = lazy_scene_of(boxes_apart(100));
  const auto engine = engine_of("", 2);
  const Deadline never = Deadline::never();
  HitBatch hits, lazy_hits;
  ASSERT_TRUE(engine->nearest(*lazy, {{40.25, 30.25, 2}}, kInf, 1, never, hits));
  EXPECT_EQ(hits.instance[0], 3040u);
  EXPECT_LE(lazy->trees().stats().trees_built, 9u);
  ASSERT_TRUE(engine->nearest(*lazy, {{-500, -500, 0}}, 7, 1, never, hits));
  EXPECT_FALSE(hits.hit(0));
  EXPECT_LE(lazy->trees().stats().trees_built, 9u);

  const auto whole = *Scene::build(description_of(boxes_apart(30)));
  std::mt19937_64 random(7);
  Column<Vec3d> points;
  for (int i = 0; i < 200; ++i) {
    const auto x = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 * 40 - 5; };
    const double a = x(), b = x();
    points.push_back({a, b, x() / 10});
  }
  for (const std::size_t count : {std::size_t{1}, std::size_t{20}}) {
    ASSERT_TRUE(engine->nearest(*whole, points, 6, count, never, hits));
    ASSERT_TRUE(
        engine->nearest(*lazy_scene_of(boxes_apart(30)), points, 6, count, never, lazy_hits));
    EXPECT_EQ(hits.t, lazy_hits.t);
    EXPECT_EQ(hits.instance, lazy_hits.instance);
    EXPECT_EQ(hits.triangle, lazy_hits.triangle);
  }
}

TEST(LazyScene, builds_one_tree_for_a_ray_into_one_box_of_many) {
  const auto scene = lazy_scene_of(boxes_apart(100));
  EXPECT_EQ(scene->trees().stats().meshes_total, 10000u);
  const auto engine = engine_of("", 2);
  HitBatch hits;
  const RayBatch ray = one_ray({40.25, 30.25, 5}, {0, 0, -1});
  ASSERT_TRUE(engine->closest(*scene, ray, Deadline::never(), hits));
  EXPECT_EQ(hits.instance[0], 3040u);
  EXPECT_EQ(scene->trees().stats().trees_built, 1u);
  EXPECT_EQ(scene->trees().stats().meshes_built, 1u);
  EXPECT_EQ(scene->trees().stats().queries_waited, 1u);
  ASSERT_TRUE(engine->closest(*scene, ray, Deadline::never(), hits));
  EXPECT_EQ(scene->trees().stats().queries_waited, 1u);
}

TEST(LazyScene, builds_nothing_for_who_will_not_wait_for_it) {
  const auto scene = lazy_scene_of(boxes_apart(3));
  const auto engine = engine_of("", 1);
  const RayBatch ray = one_ray({1.125, 1.25, 5}, {0, 0, -1});
  HitBatch hits;
  Column<std::uint8_t> any;
  Column<std::uint64_t> totals;
  const auto ask_all = [&](const RayOptions& options) {
    const Deadline never = Deadline::never();
    const Status statuses[] = {
        engine->closest(*scene, ray, never, hits, options),
        engine->any(*scene, ray, never, any, options),
        engine->count(*scene, ray, Crossings::kEvery, never, totals, options)};
    std::string said;
    for (const Status& status : statuses) said += (status ? "answered" : status.error().code) + " ";
    return said;
  };
  EXPECT_EQ(ask_all({.builds = false}), "TREES_PENDING TREES_PENDING TREES_PENDING ");
  EXPECT_EQ(scene->trees().stats().trees_built, 0u);
  for (int i = 0; i < 9; ++i) {
    const int row = i / 3;
    ASSERT_TRUE(engine->closest(*scene, one_ray({i % 3 + 0.25, row + 0.25, 5}, {0, 0, -1}),
                                Deadline::never(), hits));
  }
  EXPECT_EQ(ask_all({.builds = false}), "answered answered answered ");
  EXPECT_EQ(hits.instance[0], 4u);
  EXPECT_EQ(totals[0], 2u);
}

TEST(LazyScene, builds_nothing_behind_a_hit_nor_beyond_a_limit) {
  const auto scene = lazy_scene_of(boxes_apart(10));
  const auto engine = engine_of("", 1);
  HitBatch hits;
  // Along a row of ten boxes: the first one stops it.
  ASSERT_TRUE(
      engine->closest(*scene, one_ray({-1, 3.25, 0.05}, {1, 0, 0}), Deadline::never(), hits));
  EXPECT_EQ(hits.instance[0], 30u);
  EXPECT_EQ(scene->trees().stats().trees_built, 1u);
  Column<std::uint8_t> any;
  ASSERT_TRUE(engine->any(*scene, one_ray({-1, 4.25, 0.05}, {1, 0, 0}), Deadline::never(), any));
  EXPECT_EQ(scene->trees().stats().trees_built, 2u);
  RayBatch shorter = one_ray({-1, 5.25, 0.05}, {1, 0, 0});
  shorter.tmax[0] = 0.75;
  ASSERT_TRUE(engine->closest(*scene, shorter, Deadline::never(), hits));
  EXPECT_FALSE(hits.hit(0));
  EXPECT_EQ(scene->trees().stats().trees_built, 2u);
  Column<std::uint64_t> totals;
  ASSERT_TRUE(engine->count(*scene, one_ray({-1, 6.25, 0.05}, {1, 0, 0}), Crossings::kEvery,
                            Deadline::never(), totals));
  EXPECT_EQ(totals[0], 20u);
  EXPECT_EQ(scene->trees().stats().trees_built, 12u);
}

TEST(LazyScene, misses_no_tree_that_one_of_many_neighbouring_rays_meets) {
  constexpr std::uint32_t kSide = 30;
  const auto whole = *Scene::build(description_of(boxes_apart(kSide)));
  const auto lazy = lazy_scene_of(boxes_apart(kSide));
  std::mt19937_64 random(5);
  const auto below = [&](std::uint32_t end) { return static_cast<double>(random() % end); };
  // Packets of 64 rays, most of them to corners of a few boxes, which are corners of the trees'
  // boxes.
  RayBatch rays;
  for (int packet = 0; packet < 2000; ++packet) {
    const Vec3d from{below(80) / 2 - 5, below(80) / 2 - 5, below(9) / 2 - 2};
    const Vec3d to{below(kSide), below(kSide), 0};
    const double scale = std::ldexp(1.0, static_cast<int>(random() % 61) - 30);
    const auto moved = packet % 2 == 0 ? 0.0 : 0x1p-20;
    const auto kind = random() % 4;
    for (int i = 0; i < 64; ++i) {
      const Vec3d origin{from.x + moved * below(9), from.y + moved * below(9), from.z};
      const Vec3d target{to.x + below(6) / 2, to.y + below(3) / 2, to.z};
      Vec3d direction{(target.x - origin.x) * scale, (target.y - origin.y) * scale,
                      (target.z - origin.z) * scale};
      if (kind == 1) direction.x = 0;
      if (kind == 2) direction.y = -0.0;
      if (kind == 3) direction.x = direction.y = 0;
      if (direction == Vec3d{0, 0, 0}) direction.z = scale;
      rays.push_back({origin, direction, below(3) == 0 ? 0.5 / scale : 0});
    }
  }
  HitBatch hits;
  ASSERT_TRUE(engine_of("", 2)->closest(*whole, rays, Deadline::never(), hits));
  std::vector<std::size_t> numbers(rays.size());
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  std::vector<std::uint32_t> next(rays.size());
  const SceneView view(*lazy);
  UnbuiltTrees unbuilt(view);
  unbuilt.nearest(
      rays, numbers, [&](std::size_t i) { return hits.t[i]; }, next.data());
  std::size_t met = 0, clear = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(!hits.hit(i) || next[i] != kNone) << i;
    met += hits.hit(i) ? 1u : 0u;
    clear += next[i] == kNone ? 1u : 0u;
  }
  EXPECT_GT(met, 20'000u);
  EXPECT_GT(clear, 20'000u);
}

TEST(LazyScene, builds_nothing_for_a_ray_that_misses) {
  const auto scene = lazy_scene_of(demo::terrain(2000));
  HitBatch hits;
  ASSERT_TRUE(
      engine_of("", 1)->closest(*scene, one_ray({0, 5000, 0}, {0, 1, 0}), Deadline::never(), hits));
  EXPECT_EQ(scene->trees().stats().queries_waited, 0u);
}

/// Rays from around 1.2e39, beyond float32, to points of the scene.
RayBatch rays_from_beyond_float32(const Scene& scene) {
  std::mt19937_64 random(11);
  const auto within = [&](double least, double most) {
    return least + static_cast<double>(random() >> 11) * 0x1p-53 * (most - least);
  };
  RayBatch rays;
  for (int i = 0; i < 200; ++i) {
    Vec3d origin, direction;
    for (int k = 0; k < 3; ++k) {
      const double target = within(scene.bounds().min[k], scene.bounds().max[k]);
      origin[k] = within(-1.2e39, 1.2e39);
      direction[k] = target - origin[k];
    }
    rays.push_back({origin, direction});
  }
  return rays;
}

TEST(LazyScene, answers_rays_from_beyond_float32) {
  // Triangles that fill float32, and small ones beside a far one without an area, which widens the
  // bounds of the scene and is in no tree.
  demo::DemoScene large = demo::soup(60), small = demo::soup(60);
  float most = 0;
  for (const float x : large.meshes[0].positions) most = std::max(most, std::abs(x));
  for (float& x : large.meshes[0].positions) x *= 3e38f / most;
  demo::DemoMesh& mesh = small.meshes[0];
  const auto corner = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  mesh.positions.insert(mesh.positions.end(), {3e38f, 3e38f, 3e38f});
  mesh.indices.insert(mesh.indices.end(), {corner, corner, 0});
  for (const demo::DemoScene& demo_scene : {large, small}) {
    const auto whole = test::scene_of(demo_scene);
    const RayBatch rays = rays_from_beyond_float32(*whole);
    HitBatch truth;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      HitBatch one;
      const Ray ray = rays[i];
      ASSERT_TRUE(engine_of("", 1)->closest(*whole, one_ray(ray.origin, ray.direction),
                                            Deadline::never(), one));
      truth.t.push_back(one.t[0]);
      truth.triangle.push_back(one.triangle[0]);
    }
    for (const Kernel& kernel : supported_kernels()) {
      for (const auto& scene : {whole, lazy_scene_of(demo_scene)}) {
        HitBatch hits;
        ASSERT_TRUE(
            engine_of(std::string(kernel.name), 1)->closest(*scene, rays, Deadline::never(), hits));
        EXPECT_EQ(hits.t, truth.t) << kernel.name;
        EXPECT_EQ(hits.triangle, truth.triangle) << kernel.name;
      }
    }
  }
}

TEST(LazyScene, cuts_a_large_mesh_and_builds_the_parts_that_are_met) {
  const auto make = [] { return demo::terrain(400000); };
  const auto scene = lazy_scene_of(make());
  const auto engine = engine_of("", 2);
  HitBatch hits;
  ASSERT_TRUE(
      engine->closest(*scene, one_ray({111, 5000, 222}, {0, -1, 0}), Deadline::never(), hits));
  EXPECT_TRUE(hits.hit(0));
  EXPECT_EQ(scene->trees().stats().meshes_split, 1u);
  EXPECT_LE(scene->trees().stats().trees_built, 4u);
  EXPECT_LT(scene->trees().stats().tree_bytes, 400000u * 20);

  const auto whole = test::scene_of(make());
  const RayBatch rays = rays_into(*whole);
  EXPECT_EQ(ask(*engine, *scene, rays).hash(), ask(*engine, *whole, rays).hash());
}

TEST(LazyScene, does_not_cut_a_mesh_that_rays_are_mapped_into) {
  // Placed twice, but one placement has nothing finite: the other is alone and mapped.
  SceneDescription description = description_of(demo::terrain(200000));
  description.instances.push_back(description.instances[0]);
  for (int k = 0; k < 3; ++k) {
    description.instances[0].world_from_mesh.m[k][(k + 1) % 3] = k == 0 ? -2 : 2;
    description.instances[0].world_from_mesh.m[k][k] = 0.5;
  }
  description.instances[1].world_from_mesh.m[0][3] = std::numeric_limits<double>::infinity();
  const auto whole = *Scene::build(description);
  const auto scene = *Scene::prepare(description);
  const RayBatch rays = rays_into(*whole);
  const auto engine = engine_of("", 2);
  HitBatch truth, hits;
  ASSERT_TRUE(engine->closest(*whole, rays, Deadline::never(), truth));
  ASSERT_TRUE(engine->closest(*scene, rays, Deadline::never(), hits));
  EXPECT_EQ(hits.instance, truth.instance);
  EXPECT_EQ(hits.triangle, truth.triangle);
  EXPECT_EQ(scene->trees().stats().meshes_split, 0u);
}

TEST(LazyScene, builds_meshes_of_the_same_content_once) {
  demo::DemoScene twice = boxes_apart(2);
  for (demo::DemoMesh& mesh : twice.meshes) mesh = twice.meshes[0];
  const auto scene = lazy_scene_of(twice);
  EXPECT_EQ(scene->trees().stats().meshes_total, 1u);
  Column<std::uint64_t> totals;
  RayBatch rays;
  for (const double x : {0.25, 1.25}) rays.push_back({{x, 0.25, 5}, {0, 0, -1}});
  ASSERT_TRUE(engine_of("", 1)->count(*scene, rays, Crossings::kEvery, Deadline::never(), totals));
  EXPECT_EQ(totals, (Column<std::uint64_t>{2 + 2, 2 + 2}));
  EXPECT_EQ(scene->trees().stats().trees_built, 1u);
}

TEST(LazyScene, answers_the_same_while_many_threads_build_and_trees_come_and_go) {
  const auto make = [] { return demo::town(); };
  const auto whole = test::scene_of(make());
  const RayBatch rays = rays_into(*whole);
  const auto engine = engine_of("", 2);
  HitBatch truth;
  Column<std::uint8_t> occluded;
  ASSERT_TRUE(engine->closest(*whole, rays, Deadline::never(), truth));
  ASSERT_TRUE(engine->any(*whole, rays, Deadline::never(), occluded));

  const auto scene = lazy_scene_of(make());
  std::atomic<int> wrong{0};
  std::atomic<int> running{4};
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t begin = t * 40; begin + 200 <= rays.size(); begin += 400) {
        RayBatch some;
        for (std::size_t i = 0; i < 200; ++i) some.push_back(rays[begin + i]);
        HitBatch hits;
        Column<std::uint8_t> any;
        const bool good = engine->closest(*scene, some, Deadline::never(), hits).ok() &&
                          engine->any(*scene, some, Deadline::never(), any).ok();
        for (std::size_t i = 0; i < 200; ++i) {
          if (!good || hits.id(i) != truth.id(begin + i) || any[i] != occluded[begin + i]) ++wrong;
        }
      }
      --running;
    });
  }
  // Everything is dropped, and everything is there at once, again and again.
  for (int round = 0; running.load() > 0; ++round) {
    if (round % 2 == 0) {
      scene->trees().drop();
    } else {
      scene->trees().complete(*build_scene_tree(scene->trees().plan(), TreeQuality::kFast),
                              SceneTrees::Origin::kBuilt);
    }
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong.load(), 0);
}

TEST(LazyScene, builds_each_tree_once_whoever_asks) {
  const auto scene = lazy_scene_of(boxes_apart(20));
  const auto engine = engine_of("", 2);
  RayBatch rays;
  for (int i = 0; i < 400; ++i) {
    const int row = i / 20;
    rays.push_back({{i % 20 + 0.25, row + 0.25, 5}, {0, 0, -1}});
  }
  std::vector<std::thread> threads;
  threads.reserve(4);
  std::atomic<int> misses{0};
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      HitBatch hits;
      if (!engine->closest(*scene, rays, Deadline::never(), hits)) ++misses;
      for (std::size_t i = 0; i < rays.size(); ++i) misses += hits.instance[i] == i ? 0 : 1;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(misses.load(), 0);
  EXPECT_EQ(scene->trees().stats().trees_built, 400u);
  EXPECT_TRUE(scene->trees().stats().complete);
}

TEST(LazyScene, keeps_a_deadline_that_passed) {
  const auto scene = lazy_scene_of(demo::terrain(2000));
  HitBatch hits;
  const auto status = engine_of("", 1)->closest(*scene, one_ray({111, 5000, 222}, {0, -1, 0}),
                                                Deadline::in(std::chrono::seconds(-1)), hits);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, "DEADLINE");
}

}  // namespace
}  // namespace sightline
