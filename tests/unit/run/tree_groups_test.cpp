#include "core/trace/search/tree_groups.h"

#include <gtest/gtest.h>

#include "core/run/resolved_filter.h"
#include "tests/unit/run/golden_answers.h"

namespace sightline {
namespace {

using test::description_of;
using test::engine_of;
using test::rays_into;

/// A scene whose trees are ten times as large as what may be in memory. Rays build its trees.
std::shared_ptr<const Scene> scene_beyond_memory() {
  auto scene = *Scene::prepare(description_of(demo::terrain(200'000)));
  const std::uint64_t limit = scene->trees().held_geometry_bytes() + (600 << 10);
  const auto budget = std::make_shared<TreeBudget>(
      limit, OverflowMemory::make(testing::TempDir(), std::uint64_t{1} << 30));
  EXPECT_TRUE(scene->trees().join(budget));
  return scene;
}

std::shared_ptr<const Scene> scene_in_memory() {
  return *Scene::prepare(description_of(demo::terrain(200'000)));
}

void expect_equal(const HitBatch& a, const HitBatch& b) {
  EXPECT_EQ(a.t, b.t);
  EXPECT_EQ(a.instance, b.instance);
  EXPECT_EQ(a.triangle, b.triangle);
}

TEST(TreeGroups, give_the_answers_of_all_trees_at_once) {
  const auto scene = scene_in_memory(), beyond = scene_beyond_memory();
  const RayBatch rays = rays_into(*scene);
  const Deadline never = Deadline::never();
  for (const std::string& kernel : Engine::kernels()) {
    for (const int threads : {1, 2}) {
      const auto engine = engine_of(kernel, threads);
      HitBatch hits, of_groups;
      Column<std::uint8_t> occluded, any_of_groups;
      ASSERT_TRUE(engine->closest(*scene, rays, never, hits));
      ASSERT_TRUE(engine->any(*scene, rays, never, occluded));
      ASSERT_TRUE(engine->closest(*beyond, rays, never, of_groups));
      // Some trees may still be unbuilt: no ray met them.
      const auto groups = TreeGroups::of(*beyond, rays);
      ASSERT_TRUE(groups);
      EXPECT_GT(groups->size(), 20u);
      EXPECT_LE(groups->size(), TreeGroups::kMost);
      expect_equal(of_groups, hits);
      ASSERT_TRUE(engine->closest(*beyond, rays, never, of_groups));
      expect_equal(of_groups, hits);
      ASSERT_TRUE(engine->any(*beyond, rays, never, any_of_groups));
      EXPECT_EQ(any_of_groups, occluded);
    }
  }
}

TEST(TreeGroups, give_the_answers_of_filters_and_masks) {
  const auto scene = scene_in_memory(), beyond = scene_beyond_memory();
  RayBatch rays = rays_into(*scene);
  for (std::size_t i = 0; i < rays.size(); ++i) rays.mask.push_back(i % 3 == 0 ? 0u : 1u);
  const Deadline never = Deadline::never();
  const auto engine = engine_of("", 2);
  const auto ask = [&](const Scene& of, HitBatch& hits, Column<std::uint8_t>& occluded) {
    HitFilter filter;
    filter.culling = Culling::kBack;
    const auto resolved = resolve_for_rays(of, filter, rays.mask, never, {}, nullptr);
    ASSERT_TRUE(resolved && *resolved);
    const RayOptions options{.resolved = &**resolved};
    ASSERT_TRUE(engine->closest(of, rays, never, hits, options));
    ASSERT_TRUE(engine->any(of, rays, never, occluded, options));
  };
  HitBatch hits, of_groups, again;
  Column<std::uint8_t> occluded, any_of_groups;
  ask(*scene, hits, occluded);
  ask(*beyond, of_groups, any_of_groups);  // builds trees
  ASSERT_TRUE(TreeGroups::of(*beyond, rays));
  ask(*beyond, again, any_of_groups);
  expect_equal(of_groups, hits);
  expect_equal(again, hits);
  EXPECT_EQ(any_of_groups, occluded);
}

TEST(TreeGroups, are_for_many_rays_that_enter_many_trees) {
  const auto scene = scene_beyond_memory();
  const RayBatch rays = rays_into(*scene);
  EXPECT_FALSE(TreeGroups::of(*scene, rays)) << "no tree is built";
  HitBatch hits;
  ASSERT_TRUE(engine_of("", 2)->closest(*scene, rays, Deadline::never(), hits));
  EXPECT_TRUE(TreeGroups::of(*scene, rays));
  RayBatch few, alike;
  for (std::size_t i = 0; i < TreeGroups::kSample - 1; ++i) few.push_back(rays[i]);
  for (std::size_t i = 0; i < rays.size(); ++i) alike.push_back(rays[0]);
  EXPECT_FALSE(TreeGroups::of(*scene, few));
  EXPECT_FALSE(TreeGroups::of(*scene, alike));
}

TEST(TreeGroups, end_at_the_deadline) {
  const auto scene = scene_beyond_memory();
  const RayBatch rays = rays_into(*scene);
  const auto engine = engine_of("", 2);
  HitBatch hits;
  ASSERT_TRUE(engine->closest(*scene, rays, Deadline::never(), hits));
  CancelFlag flag;
  flag.cancel();
  Deadline cancelled = Deadline::never();
  cancelled.flag = &flag;
  const Status status = engine->closest(*scene, rays, cancelled, hits);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, "CANCELLED");
}

}  // namespace
}  // namespace sightline
