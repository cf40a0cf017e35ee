// Batches of boxes through the engine: the same answers for every number of threads and order,
// limits and deadlines kept.

#include <gtest/gtest.h>

#include <random>

#include "core/demo/demo.h"
#include "core/import/import.h"
#include "core/run/engine.h"

namespace sightline {
namespace {

std::shared_ptr<const Scene> town() {
  static const std::shared_ptr<const Scene> scene = [] {
    Result<SceneDescription> description = import_bytes(demo::write_glb(demo::town()), {});
    EXPECT_TRUE(description.ok());
    return *Scene::build(std::move(*description));
  }();
  return scene;
}

std::unique_ptr<Engine> engine(int threads) { return *Engine::create({threads, ""}); }

BoxBatch boxes_in(const Scene& scene, std::size_t count) {
  std::mt19937_64 random(12);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const Box3d& bounds = scene.bounds();
  BoxBatch boxes;
  while (boxes.size() < count) {
    Vec3d at, half;
    for (int k = 0; k < 3; ++k) {
      at[k] = bounds.min[k] + unit() * (bounds.max[k] - bounds.min[k]);
      half[k] = unit() * 8;
    }
    if (boxes.size() % 2 == 0) {
      boxes.push_back(Box3d{at, {at.x + half.x, at.y + half.y, at.z + half.z}});
    } else {
      boxes.push_back(OrientedBox{at, half, rotated_axes(0, 0.6, 0, 0.8)});
    }
  }
  return boxes;
}

TEST(EngineBoxes, answer_the_same_on_one_thread_and_on_two) {
  const auto scene = town();
  const BoxBatch boxes = boxes_in(*scene, 300);
  Column<std::uint64_t> totals[2], counts, node_totals;
  BoxLists lists[2], nodes;
  Column<std::uint8_t> touched;
  for (const int threads : {1, 2}) {
    const auto own = engine(threads);
    const auto i = static_cast<std::size_t>(threads - 1);
    ASSERT_TRUE(own->boxes_list(*scene, boxes, BoxTargets::kTriangles, {50, 100000},
                                Deadline::never(), lists[i], totals[i]));
    ASSERT_TRUE(own->boxes_count(*scene, boxes, BoxTargets::kTriangles, Deadline::never(), counts));
    ASSERT_TRUE(own->boxes_any(*scene, boxes, Deadline::never(), touched));
    ASSERT_TRUE(own->boxes_list(*scene, boxes, BoxTargets::kNodes, {50, 100000}, Deadline::never(),
                                nodes, node_totals));
    EXPECT_EQ(counts, totals[i]);
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      EXPECT_EQ(touched[b] != 0, totals[i][b] > 0);
      EXPECT_EQ(node_totals[b] > 0, totals[i][b] > 0);
    }
  }
  EXPECT_EQ(totals[0], totals[1]);
  EXPECT_EQ(lists[0].first, lists[1].first);
  EXPECT_EQ(lists[0].triangles, lists[1].triangles);
  EXPECT_GT(lists[0].triangles.size(), 500u);
  EXPECT_EQ(lists[0].first.back(), lists[0].triangles.size());
}

TEST(EngineBoxes, expect_what_the_sides_of_a_shape_say) {
  const auto scene = town();
  const std::uint64_t all = scene->instanced_triangle_count();
  const Box3d& bounds = scene->bounds();
  const Vec3d middle{(bounds.min.x + bounds.max.x) / 2, (bounds.min.y + bounds.max.y) / 2,
                     (bounds.min.z + bounds.max.z) / 2};
  const auto expected = [&](const auto& shape) {
    BoxBatch boxes;
    boxes.push_back(shape);
    return Engine::expected_triangles(*scene, boxes);
  };
  const double inf = Box3d::kInf;
  EXPECT_EQ(expected(Box3d{{-inf, -inf, -inf}, {inf, inf, inf}}), all);
  EXPECT_EQ(expected(Box3d{{bounds.max.x + 1, -inf, -inf}, {inf, inf, inf}}), 0u);
  // A quarter of the area of a floor.
  EXPECT_NEAR(static_cast<double>(expected(Box3d{bounds.min, middle})),
              static_cast<double>(all) / 4, 1);
  // A column through the whole town, of a hundredth of its width and depth: at least an eighth.
  const Vec3d thin{bounds.min.x + (bounds.max.x - bounds.min.x) / 100, bounds.max.y,
                   bounds.min.z + (bounds.max.z - bounds.min.z) / 100};
  EXPECT_NEAR(static_cast<double>(expected(Box3d{bounds.min, thin})), static_cast<double>(all) / 8,
              1);
  EXPECT_EQ(expected(Sphere{middle, 1}), all / 8);
  EXPECT_EQ(expected(Sphere{middle, 1e300}), all);
  EXPECT_EQ(expected(OrientedBox{middle, {1, 1, 1}, rotated_axes(0, 0.6, 0, 0.8)}), all / 8);
  const HalfSpace plane{{0, 1, 0}, bounds.min.y};
  EXPECT_EQ(expected(ConvexRegion{{&plane, 1}}), all);
  // Many shapes: the sum of each, also beyond 2^32.
  BoxBatch many;
  for (int i = 0; i < 20000; ++i) many.push_back(Box3d{{-inf, -inf, -inf}, {inf, inf, inf}});
  EXPECT_EQ(Engine::expected_triangles(*scene, many), 20000 * all);
  EXPECT_EQ(Engine::expected_triangles(*scene, BoxBatch{}), 0u);
}

TEST(EngineBoxes, refuse_lists_beyond_what_is_allowed) {
  const auto scene = town();
  BoxBatch boxes;
  boxes.push_back(scene->bounds());
  BoxLists lists;
  Column<std::uint64_t> totals;
  const Status status = engine(1)->boxes_list(*scene, boxes, BoxTargets::kTriangles,
                                              {1000000, 1000}, Deadline::never(), lists, totals);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, "TOO_MANY_HITS");
  ASSERT_TRUE(
      engine(1)->boxes_count(*scene, boxes, BoxTargets::kTriangles, Deadline::never(), totals));
  EXPECT_EQ(totals[0], scene->instanced_triangle_count())
      << "the town has no triangle without area";
}

TEST(EngineBoxes, stop_when_cancelled_in_the_middle_of_a_box) {
  const auto scene = town();
  BoxBatch boxes;
  boxes.push_back(scene->bounds());
  CancelFlag flag;
  flag.cancel();
  Column<std::uint64_t> totals;
  const Status status = engine(1)->boxes_count(*scene, boxes, BoxTargets::kTriangles,
                                               Deadline::in(std::chrono::hours(1), &flag), totals);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, "CANCELLED");
}

TEST(EngineBoxes, pair_rays_with_boxes_one_by_one_or_all_with_all) {
  RayBatch rays;
  BoxBatch boxes;
  for (int i = 0; i < 3; ++i) {
    rays.push_back({{-10, 4.0 * i, 0}, {1, 0, 0}});
    boxes.push_back(Box3d{{-1, 4.0 * i - 1, -1}, {1, 4.0 * i + 1, 1}});
  }
  RayBoxAnswers answers;
  const auto own = engine(2);
  ASSERT_TRUE(own->ray_boxes(rays, boxes, BoxPairing::kEach, RayBoxDetail::kAll, Deadline::never(),
                             answers));
  ASSERT_EQ(answers.size(), 3u);
  EXPECT_TRUE(answers.planes.empty());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(answers.outcome[i], RayBoxOutcome::kHit);
    EXPECT_EQ(answers.t[i], 9);
    EXPECT_EQ(answers.normal[i], (Vec3d{-1, 0, 0}));
  }
  ASSERT_TRUE(own->ray_boxes(rays, boxes, BoxPairing::kAll, RayBoxDetail::kPlanes,
                             Deadline::never(), answers));
  ASSERT_EQ(answers.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(answers.outcome[i] == RayBoxOutcome::kHit, i / 3 == i % 3) << i;
    EXPECT_EQ(answers.planes[i][0], 9);
  }
  boxes = {};
  ASSERT_TRUE(own->ray_boxes(rays, boxes, BoxPairing::kAll, RayBoxDetail::kPlanes,
                             Deadline::never(), answers));
  EXPECT_EQ(answers.size(), 0u);
}

}  // namespace
}  // namespace sightline
