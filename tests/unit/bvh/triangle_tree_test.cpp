// What the builder promises beyond soundness.

#include "core/bvh/triangle_tree.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "core/base/parallel.h"
#include "core/base/thread_group.h"
#include "tests/unit/bvh/test_mesh.h"

namespace sightline {
namespace {

WideTree build_on(int threads, const MeshView& mesh, TreeQuality quality) {
  ThreadGroup group;
  group.start(threads);
  WideTree tree;
  group.execute([&] { tree = build_triangle_tree(mesh, nullptr, quality); });
  return tree;
}

TEST(TriangleTree, is_whole_or_empty_whenever_it_is_cancelled) {
  const TestMesh mesh(demo::terrain(60'000).meshes[0]);
  for (const TreeQuality quality : {TreeQuality::kFast, TreeQuality::kHigh}) {
    const WideTree whole = build_triangle_tree(mesh.view(), nullptr, quality);
    int empty = 0;
    for (int wait = 0; wait < 40; ++wait) {
      CancelFlag cancel;
      std::thread canceller([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(wait));
        cancel.cancel();
      });
      const WideTree tree = build_triangle_tree(mesh.view(), nullptr, quality, &cancel);
      canceller.join();
      if (tree.root == ChildRef::kEmpty) {
        ++empty;
        EXPECT_EQ(tree.node_count, 0u);
        continue;
      }
      ASSERT_EQ(tree.arena.used(), whole.arena.used()) << wait;
      EXPECT_EQ(std::memcmp(tree.arena.at(0), whole.arena.at(0), whole.arena.used()), 0) << wait;
    }
    EXPECT_GT(empty, 0);
    CancelFlag cancelled;
    cancelled.cancel();
    EXPECT_EQ(build_triangle_tree(mesh.view(), nullptr, quality, &cancelled).root,
              ChildRef::kEmpty);
  }
}

TEST(TriangleTree, has_the_same_bytes_from_any_number_of_threads) {
  // Enough triangles that every step shares its work.
  for (const demo::DemoScene& scene : {demo::terrain(200'000), demo::city(150'000)}) {
    const TestMesh mesh(scene.meshes[0]);
    for (const TreeQuality quality : {TreeQuality::kFast, TreeQuality::kHigh}) {
      const WideTree one = build_on(1, mesh.view(), quality);
      for (const int threads : {2, 3, 7}) {
        const WideTree many = build_on(threads, mesh.view(), quality);
        ASSERT_EQ(many.arena.used(), one.arena.used()) << scene.name;
        EXPECT_EQ(std::memcmp(many.arena.at(0), one.arena.at(0), one.arena.used()), 0)
            << scene.name;
        EXPECT_EQ(many.root, one.root);
        EXPECT_EQ(many.node_count, one.node_count);
        EXPECT_EQ(many.block_count, one.block_count);
        EXPECT_EQ(many.depth, one.depth);
      }
    }
  }
}

TEST(TriangleTree, stays_shallow_where_centroids_cannot_be_told_apart) {
  // Nested boxes around one point, and many copies of one triangle.
  std::vector<Vec3f> positions;
  std::vector<std::uint32_t> indices;
  for (int i = 0; i < 3000; ++i) {
    const float size = i < 1500 ? std::ldexp(1.0f, i % 60 - 30) : 1.0f;
    for (const Vec3f& p :
         {Vec3f{-size, -size, -size}, Vec3f{size, size, -size}, Vec3f{size, -size, size}}) {
      indices.push_back(static_cast<std::uint32_t>(positions.size()));
      positions.push_back(p);
    }
  }
  const WideTree tree = build_triangle_tree({positions, indices}, nullptr, TreeQuality::kFast);
  EXPECT_LE(tree.depth, 16u);
}

TEST(SceneTree, says_how_deep_it_is) {
  const TestMesh large(demo::soup(3000).meshes[0]);
  const MeshView view = large.view();
  std::vector<PlacementView> placements(1);
  Result<SceneTree> one = build_scene_tree({&view, 1}, placements);
  ASSERT_TRUE(one.ok());
  EXPECT_EQ(one->depth, one->trees[0]->depth);
  EXPECT_GE(one->depth, 3u);

  // So many copies that they stay apart.
  placements.resize(600);
  for (std::size_t i = 0; i < placements.size(); ++i)
    placements[i].world_from_mesh.m[0][3] = 3.0 * static_cast<double>(i);
  Result<SceneTree> many = build_scene_tree({&view, 1}, placements);
  ASSERT_TRUE(many.ok());
  EXPECT_EQ(many->depth, many->top.depth + many->trees[0]->depth);
}

TEST(TriangleTree, fills_its_blocks) {
  const TestMesh mesh(demo::terrain(100'000).meshes[0]);
  const WideTree tree = build_triangle_tree(mesh.view(), nullptr, TreeQuality::kFast);
  const double lanes = 4.0 * tree.block_count;
  EXPECT_GT(static_cast<double>(mesh.view().triangle_count()) / lanes, 0.75);
}

}  // namespace
}  // namespace sightline
