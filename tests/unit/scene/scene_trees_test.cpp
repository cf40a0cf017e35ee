// The cache of trees and the budget that several scenes share.

#include "core/scene/scene_trees.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/base/thread_group.h"
#include "core/demo/random.h"
#include "tests/unit/scene/small_scenes.h"

namespace sightline {
namespace {

using test::description_of;

std::shared_ptr<const Scene> terrain(std::uint32_t triangles, std::uint64_t seed = 1) {
  return *Scene::prepare(description_of(demo::terrain(triangles, seed)));
}

void build_everything(const Scene& scene) {
  ThreadGroup threads;
  threads.start(1);
  const SceneTrees::Use use(scene.trees());
  auto tree = scene.tree();
  while (!tree->complete()) {
    std::vector<std::uint32_t> all(tree->trees.size());
    std::iota(all.begin(), all.end(), 0u);
    tree = *scene.trees().build(tree, all, Deadline::never(), threads);
  }
}

TEST(SceneTrees, begin_with_nothing_and_end_with_everything) {
  const auto scene = *Scene::prepare(description_of(demo::town()));
  TreeStats stats = scene->trees().stats();
  EXPECT_EQ(stats.meshes_built, 0u);
  EXPECT_FALSE(stats.complete);
  build_everything(*scene);
  stats = scene->trees().stats();
  EXPECT_EQ(stats.meshes_built, stats.meshes_total);
  EXPECT_TRUE(stats.complete);
  EXPECT_GT(stats.tree_bytes, 0u);
  EXPECT_TRUE(scene->trees().wants_all());
  scene->trees().complete(*build_scene_tree(scene->trees().plan()), SceneTrees::Origin::kBuilt);
  EXPECT_FALSE(scene->trees().wants_all());
  EXPECT_EQ(scene->trees().stats().full_builds, 1u);
}

TEST(SceneTrees, know_the_same_bounds_before_and_after) {
  for (const auto& make : {+[] { return demo::town(); }, +[] { return test::three_sizes(); }}) {
    const auto before = *Scene::prepare(description_of(make()));
    const auto after = *Scene::build(description_of(make()));
    EXPECT_EQ(before->bounds(), after->bounds());
    EXPECT_EQ(before->tree()->bounds, before->bounds());
    EXPECT_EQ(after->tree()->bounds, after->bounds());
  }
}

TEST(TreeBudget, drops_the_trees_that_were_asked_the_longest_ago) {
  const auto first = terrain(5000, 1), second = terrain(5000, 2), third = terrain(5000, 3);
  build_everything(*third);
  const std::uint64_t one = third->trees().held_geometry_bytes() + third->trees().tree_bytes();
  third->trees().drop();
  const auto budget = std::make_shared<TreeBudget>(one * 3 - one / 3);
  for (const auto& scene : {first, second, third}) ASSERT_TRUE(scene->trees().join(budget));
  build_everything(*first);
  build_everything(*second);
  EXPECT_TRUE(first->tree()->complete());
  { const SceneTrees::Use use(first->trees()); }
  build_everything(*third);
  EXPECT_TRUE(first->tree()->complete());
  EXPECT_FALSE(second->tree()->complete());
  EXPECT_TRUE(third->tree()->complete());
  EXPECT_EQ(second->trees().stats().evictions, 1u);
  EXPECT_LE(budget->used(), budget->limit());
  build_everything(*second);
  EXPECT_TRUE(second->tree()->complete());
}

TEST(TreeBudget, counts_also_what_scenes_have_cost_that_are_no_more) {
  const auto budget = std::make_shared<TreeBudget>(0);
  const auto first = terrain(5000, 1);
  auto second = terrain(5000, 2);
  for (const auto& scene : {first, second}) ASSERT_TRUE(scene->trees().join(budget));
  build_everything(*first);
  build_everything(*second);
  second->trees().drop();
  const TreeTotals before = budget->totals();
  EXPECT_GE(before.trees_built, 2u);
  EXPECT_EQ(before.evictions, 1u);
  EXPECT_EQ(before.geometry_bytes + before.tree_bytes, budget->used());
  second.reset();
  const TreeTotals after = budget->totals();
  EXPECT_EQ(after.trees_built, before.trees_built);
  EXPECT_EQ(after.evictions, 1u);
  EXPECT_EQ(after.geometry_bytes, first->trees().held_geometry_bytes());
}

TEST(TreeBudget, counts_what_is_there_now) {
  const auto budget = std::make_shared<TreeBudget>(0);
  const auto sum = [](std::initializer_list<const Scene*> scenes) {
    std::uint64_t bytes = 0;
    for (const Scene* scene : scenes)
      bytes += scene->trees().held_geometry_bytes() + scene->trees().held_tree_bytes();
    return bytes;
  };
  const auto first = terrain(5000, 1);
  build_everything(*first);  // before it joins
  auto second = terrain(9000, 2);
  for (const auto& scene : {first, second}) ASSERT_TRUE(scene->trees().join(budget));
  EXPECT_EQ(budget->used(), sum({&*first, &*second}));
  build_everything(*second);
  EXPECT_EQ(budget->used(), sum({&*first, &*second}));
  first->trees().complete(*build_scene_tree(first->trees().plan()), SceneTrees::Origin::kBuilt);
  EXPECT_EQ(budget->used(), sum({&*first, &*second}));
  // A revision shares the geometry, which counts once.
  NodeChange change;
  change.node = first->description().instances[0].node;
  change.parent_from_node = demo::translation(1, 2, 3);
  {
    const auto moved = *first->changed({&change, 1});
    ASSERT_TRUE(moved->trees().join(budget));
    EXPECT_EQ(budget->used(), sum({&*first, &*second}) + moved->trees().held_tree_bytes());
  }
  second->trees().drop();
  EXPECT_EQ(budget->used(), sum({&*first, &*second}));
  second.reset();
  EXPECT_EQ(budget->used(), sum({&*first}));
}

TEST(SceneTrees, know_what_the_lasting_form_takes_once_it_was_there) {
  const auto scene = *Scene::prepare(description_of(demo::town()));
  SceneTrees& trees = scene->trees();
  SceneTree lasting = *build_scene_tree(trees.plan());
  const std::uint64_t bytes = lasting.bytes();
  // Placements that share a tree in world space have copies of their triangles in it.
  EXPECT_LT(trees.lasting_build_bytes(), bytes);
  trees.complete(std::move(lasting), SceneTrees::Origin::kBuilt);
  trees.drop();
  EXPECT_GE(trees.lasting_build_bytes(), bytes);
  NodeChange change;
  change.node = scene->description().instances[0].node;
  change.parent_from_node = demo::translation(1, 2, 3);
  const auto moved = *scene->changed({&change, 1});
  EXPECT_GE(moved->trees().lasting_build_bytes(), bytes);
}

TEST(SceneTrees, estimate_a_moved_scene_as_a_whole) {
  const auto scene = terrain(200'000);
  build_everything(*scene);
  NodeChange change;
  change.node = scene->description().instances[0].node;
  change.parent_from_node = demo::translation(1, 2, 3);
  const auto moved = *scene->changed({&change, 1});
  EXPECT_GE(moved->trees().full_tree_bytes(), scene->trees().tree_bytes());
}

TEST(TreeBudget, leaves_the_trees_of_a_running_query_alone) {
  const auto first = terrain(5000, 1), second = terrain(5000, 2);
  build_everything(*second);
  const std::uint64_t one = second->trees().held_geometry_bytes() + second->trees().tree_bytes();
  second->trees().drop();
  const auto budget = std::make_shared<TreeBudget>(one + one / 2);
  for (const auto& scene : {first, second}) ASSERT_TRUE(scene->trees().join(budget));
  build_everything(*first);
  {
    const SceneTrees::Use use(first->trees());
    build_everything(*second);
    EXPECT_TRUE(first->tree()->complete());
  }
  EXPECT_LE(budget->used(), budget->limit());
}

TEST(TreeBudget, refuses_a_scene_that_cannot_fit) {
  const auto scene = terrain(5000);
  const Status status = scene->trees().join(std::make_shared<TreeBudget>(100000));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, "SCENE_OVER_BUDGET");
  EXPECT_NE(status.error().message.find("100000"), std::string::npos);
}

}  // namespace
}  // namespace sightline
