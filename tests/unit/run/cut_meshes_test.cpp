// Meshes with several trees: the bytes of a scene whose meshes have one each.

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "core/base/infinity.h"
#include "core/demo/random.h"
#include "core/query/sweep_batch.h"
#include "core/scene/tree_cache.h"
#include "tests/unit/run/golden_answers.h"

namespace sightline {
namespace {

using test::ask;
using test::description_of;
using test::engine_of;
using test::rays_into;

/// Small, so that most meshes are cut.
constexpr std::uint32_t kFew = 300;

/// Trees of which none is built.
std::shared_ptr<const Scene> cut_scene(SceneDescription description) {
  return *Scene::prepare(std::move(description), kFew);
}

void build_all(const Scene& scene) {
  auto trees = build_scene_tree(scene.trees().plan());
  ASSERT_TRUE(trees);
  scene.trees().complete(std::move(*trees), SceneTrees::Origin::kBuilt);
}

/// A terrain at four places: as it is, twice turned, and flattened.
SceneDescription four_terrains() {
  SceneDescription description = description_of(demo::terrain(3000));
  const Instance first = description.instances[0];
  for (int i = 1; i < 4; ++i) {
    Instance instance = first;
    instance.world_from_mesh.m[0][3] = 3000.0 * i;
    instance.world_from_mesh.m[0][1] = i == 3 ? 0 : 0.5 * i;
    if (i == 3) instance.world_from_mesh.m[1][1] = 0;
    description.instances.push_back(instance);
  }
  return description;
}

/// Hash of the answers to questions without rays.
std::uint64_t hash_of_searches(const Scene& scene, const RayBatch& rays) {
  const auto engine = engine_of("", 2);
  const Deadline never = Deadline::never();
  Column<Vec3d> points;
  BoxBatch boxes;
  SweepBatch sweeps;
  for (std::size_t i = 0; i < 60; ++i) {
    const Vec3d at = rays[i].origin;
    points.push_back(at);
    boxes.push_back(Box3d{at, {at.x + 90, at.y + 90, at.z + 90}});
    sweeps.push_back_sphere(rays[i], 0.5);
  }
  HitBatch nearest, swept;
  EXPECT_TRUE(engine->nearest(scene, points, kInf, 3, never, nearest));
  EXPECT_TRUE(engine->sweep(scene, sweeps, false, never, swept));
  BoxLists lists;
  Column<std::uint64_t> totals;
  EXPECT_TRUE(engine->boxes_list(scene, boxes, BoxTargets::kTriangles, {50, 1u << 20}, never, lists,
                                 totals));
  std::uint64_t hash = test::hash_column(totals);
  for (const std::uint64_t each :
       {test::hash_column(nearest.t), test::hash_column(nearest.instance),
        test::hash_column(nearest.triangle), test::hash_column(swept.t),
        test::hash_column(swept.triangle)}) {
    hash = test::combine(hash, each);
  }
  for (const TriangleId& id : lists.triangles) {
    const std::uint32_t both[] = {id.instance, id.triangle};
    hash = test::combine(hash, test::golden_hash(std::as_bytes(std::span(both))));
  }
  return hash;
}

TEST(CutMeshes, answer_the_golden_bytes) {
  for (const test::Golden& golden : test::kGolden) {
    const auto scene = cut_scene(description_of(golden.make()));
    const RayBatch rays = rays_into(*scene);
    const auto engine = engine_of("", 2);
    EXPECT_EQ(ask(*engine, *scene, rays).hash(), golden.hash) << golden.name;
    build_all(*scene);
    ASSERT_TRUE(scene->tree()->complete());
    for (const std::string& kernel : Engine::kernels())
      EXPECT_EQ(ask(*engine_of(kernel, 1), *scene, rays).hash(), golden.hash)
          << golden.name << " " << kernel;
  }
}

TEST(CutMeshes, have_trees_of_a_limited_size) {
  const auto scene = cut_scene(description_of(demo::terrain(20000)));
  const RayBatch rays = rays_into(*scene);
  HitBatch hits;
  ASSERT_TRUE(engine_of("", 1)->closest(*scene, rays, Deadline::never(), hits));
  EXPECT_GE(scene->trees().stats().meshes_split, 1u);
  for (const auto& tree : scene->tree()->trees) EXPECT_LE(tree->block_count, kFew);
  build_all(*scene);
  EXPECT_GE(scene->tree()->trees.size(), 66u);
  EXPECT_EQ(scene->tree()->entries, scene->tree()->trees.size());
  for (const auto& tree : scene->tree()->trees) EXPECT_LE(tree->block_count, kFew);
}

TEST(CutMeshes, are_placed_many_times) {
  const auto whole = *Scene::build(four_terrains());
  const RayBatch rays = rays_into(*whole);
  const auto engine = engine_of("", 2);
  const std::uint64_t answers = ask(*engine, *whole, rays).hash();
  const std::uint64_t searches = hash_of_searches(*whole, rays);
  const auto scene = cut_scene(four_terrains());
  EXPECT_EQ(hash_of_searches(*scene, rays), searches);
  EXPECT_EQ(ask(*engine, *scene, rays).hash(), answers);
  build_all(*scene);
  EXPECT_EQ(hash_of_searches(*scene, rays), searches);
  EXPECT_EQ(ask(*engine, *scene, rays).hash(), answers);
  // The trees of the mesh serve the placements that are turned.
  EXPECT_LT(scene->tree()->trees.size(), scene->tree()->entries);
}

/// The trees of the lasting form that are finished one by one.
std::vector<FinishedTree> finished_trees(const Scene& scene) {
  std::vector<FinishedTree> finished;
  const auto all =
      build_scene_tree(scene.trees().plan(), TreeQuality::kHigh, Joining::kNever, nullptr,
                       [&](const FinishedTree& tree) { finished.push_back(tree); });
  EXPECT_TRUE(all);
  EXPECT_EQ(finished.size(), all->trees.size());
  return finished;
}

/// Replaces the trees of a scene by finished ones, one at a time, and expects the same answers.
void expect_equal_answers(const Scene& scene, const Scene& whole) {
  const RayBatch rays = rays_into(whole);
  const auto engine = engine_of("", 2);
  const std::uint64_t answers = ask(*engine, whole, rays).hash();
  const std::uint64_t searches = hash_of_searches(whole, rays);
  EXPECT_EQ(ask(*engine, scene, rays).hash(), answers);
  std::vector<std::shared_ptr<const WideTree>> made;
  for (const FinishedTree& finished : finished_trees(scene)) {
    scene.trees().replace({&finished, 1});
    made.push_back(finished.tree);
    EXPECT_EQ(ask(*engine, scene, rays).hash(), answers);
    EXPECT_EQ(hash_of_searches(scene, rays), searches);
  }
  const auto tree = scene.tree();
  EXPECT_TRUE(tree->complete());
  for (std::uint32_t i = 0; i < tree->entries; ++i) {
    const auto& entered = tree->trees[tree->placements[i].tree];
    EXPECT_TRUE(std::find(made.begin(), made.end(), entered) != made.end()) << i;
  }
}

TEST(CutMeshes, take_finished_trees_one_by_one) {
  expect_equal_answers(*cut_scene(four_terrains()), **Scene::build(four_terrains()));
  // Rays build the trees of many small parts of each finished one.
  const auto ground = [] { return description_of(demo::terrain(200'000)); };
  const auto scene = *Scene::prepare(ground(), 70'000);
  expect_equal_answers(*scene, **Scene::build(ground()));
  EXPECT_EQ(scene->tree()->entries, 3u);
}

TEST(CutMeshes, answer_while_trees_are_replaced) {
  const auto whole = *Scene::build(four_terrains());
  const RayBatch rays = rays_into(*whole);
  const std::uint64_t answers = ask(*engine_of("", 1), *whole, rays).hash();
  const auto scene = cut_scene(four_terrains());
  const std::vector<FinishedTree> finished = finished_trees(*scene);
  std::vector<std::thread> threads;
  threads.reserve(2);
  for (int i = 0; i < 2; ++i) {
    threads.emplace_back([&] {
      const auto engine = engine_of("", 1);
      for (int round = 0; round < 4; ++round) EXPECT_EQ(ask(*engine, *scene, rays).hash(), answers);
    });
  }
  for (const FinishedTree& each : finished) {
    scene->trees().replace({&each, 1});
    std::this_thread::yield();
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(CutMeshes, take_finished_trees_of_whole_meshes) {
  // Nothing is built before: placements that share a mesh enter its finished tree.
  const auto scene = *Scene::prepare(four_terrains());
  for (const FinishedTree& finished : finished_trees(*scene))
    scene->trees().replace({&finished, 1});
  EXPECT_TRUE(scene->tree()->complete());
  EXPECT_EQ(scene->trees().stats().trees_built, 0u);
  EXPECT_EQ(scene->trees().stats().meshes_built, 1u);
  const auto whole = *Scene::build(four_terrains());
  const RayBatch rays = rays_into(*whole);
  EXPECT_EQ(hash_of_searches(*scene, rays), hash_of_searches(*whole, rays));
}

TEST(CutMeshes, leave_out_finished_trees_that_fit_no_part) {
  const auto scene = cut_scene(four_terrains());
  const std::vector<FinishedTree> finished = finished_trees(*scene);
  const auto before = scene->tree();
  // The mesh is not cut yet.
  scene->trees().replace({&finished.front(), 1});
  EXPECT_EQ(scene->tree()->unbuilt_count, before->unbuilt_count);
  const RayBatch rays = rays_into(*scene);
  const std::uint64_t answers = ask(*engine_of("", 2), *scene, rays).hash();
  FinishedTree less = finished.front();
  const std::vector<TriangleRun> runs(less.part.runs.begin(), less.part.runs.end() - 1);
  less.part.runs = runs;
  scene->trees().replace({&less, 1});
  for (const auto& tree : scene->tree()->trees) EXPECT_NE(tree, less.tree);
  EXPECT_EQ(ask(*engine_of("", 2), *scene, rays).hash(), answers);
}

TEST(CutMeshes, are_stored_and_read_again) {
  const auto scene = cut_scene(four_terrains());
  build_all(*scene);
  const ScenePlan& plan = scene->trees().plan();
  const std::uint64_t content = content_hash(plan);
  const auto bytes_of = [&](const SceneTree& tree) {
    const EncodedTrees encoded = encode_trees(tree, content);
    Column<std::byte> bytes(encoded.head.begin(), encoded.head.end());
    for (const auto& arena : encoded.arenas) bytes.insert(bytes.end(), arena.begin(), arena.end());
    return bytes;
  };
  const auto bytes = bytes_of(*scene->tree());
  auto read = decode_trees(plan, content, bytes, std::make_shared<int>());
  ASSERT_TRUE(read) << read.error().message;
  const auto again = cut_scene(four_terrains());
  again->trees().complete(std::move(*read), SceneTrees::Origin::kRead);
  const RayBatch rays = rays_into(*scene);
  EXPECT_EQ(hash_of_searches(*again, rays), hash_of_searches(*scene, rays));

  SceneTree swapped = share(*scene->tree());
  std::swap(swapped.trees[0], swapped.trees[1]);
  swapped.top_memory = std::make_shared<const WideTree>(
      WideTree::alias(std::shared_ptr<const WideTree>(scene->tree(), &scene->tree()->top)));
  swapped.top = WideTree::alias(swapped.top_memory);
  const auto other = bytes_of(swapped);
  const auto refused = decode_trees(plan, content, other, std::make_shared<int>());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, "TREES_DAMAGED");
}

TEST(CutMeshes, move) {
  for (const bool lasting : {false, true}) {
    auto scene = cut_scene(four_terrains());
    auto whole = *Scene::build(four_terrains());
    if (lasting) build_all(*scene);
    for (int round = 0; round < 3; ++round) {
      NodeChange change;
      change.node = scene->description().instances[0].node;
      change.parent_from_node =
          demo::translation(5, 100.0 * round, 7) * demo::scaling(1, round == 1 ? -2 : 1.5, 1);
      scene = *scene->changed({&change, 1});
      whole = *whole->changed({&change, 1});
      const RayBatch rays = rays_into(*whole);
      EXPECT_EQ(hash_of_searches(*scene, rays), hash_of_searches(*whole, rays)) << round;
      EXPECT_EQ(ask(*engine_of("", 2), *scene, rays).hash(),
                ask(*engine_of("", 1), *whole, rays).hash())
          << round;
    }
  }
}

TEST(CutMeshes, move_beside_others_that_share_a_tree) {
  demo::DemoScene both = demo::six_triangles();
  const auto ground = static_cast<std::uint32_t>(both.nodes.size());
  both.nodes.push_back({"ground", -1, static_cast<int>(both.meshes.size()), {}});
  both.meshes.push_back(demo::terrain(3000).meshes[0]);
  auto scene = cut_scene(description_of(both));
  build_all(*scene);
  auto whole = *Scene::build(description_of(both));
  const auto built = scene->trees().now();
  ASSERT_GT(built->placements.size(), built->entries);
  // "ground" is cut again beside the others, then "left" leaves them.
  for (const NodeChange& change : {NodeChange{ground, demo::translation(3, -400, 2), {}, {}},
                                   NodeChange{1, demo::translation(0, 2, 0), {}, {}}}) {
    scene = *scene->changed({&change, 1});
    whole = *whole->changed({&change, 1});
    RayBatch rays = rays_into(*whole);
    for (const double x : {-5.0, 3.0}) rays.push_back({{x, 10, 0}, {0, -1, 0}});
    EXPECT_EQ(hash_of_searches(*scene, rays), hash_of_searches(*whole, rays)) << change.node;
    EXPECT_EQ(ask(*engine_of("", 2), *scene, rays).hash(),
              ask(*engine_of("", 1), *whole, rays).hash())
        << change.node;
    EXPECT_EQ(scene->trees().stats().meshes_split, change.node == ground ? 1u : 0u);
  }
}

}  // namespace
}  // namespace sightline
