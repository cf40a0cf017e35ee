// Which placements come into one tree, and what the scene's trees then say of themselves.

#include "core/bvh/joining.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/bvh/validate.h"
#include "tests/unit/bvh/test_mesh.h"

namespace sightline {
namespace {

/// A mesh that claims to have that many triangles; only their number is looked at.
class Choice {
 public:
  std::uint32_t add_mesh(std::size_t triangles) {
    indices_.resize(std::max(indices_.size(), 3 * triangles));
    counts_.push_back(triangles);
    return static_cast<std::uint32_t>(counts_.size() - 1);
  }
  void place(std::uint32_t mesh, std::size_t times, double size = 1) {
    for (std::size_t i = 0; i < times; ++i) {
      placements_.push_back({mesh, {}});
      placed_.push_back({{0, 0, 0}, {size, size, size}});
    }
  }
  void place_nothing(std::uint32_t mesh) {
    placements_.push_back({mesh, {}});
    placed_.push_back({});
  }
  std::vector<std::uint32_t> made() const {
    std::vector<MeshView> meshes;
    for (const std::size_t count : counts_)
      meshes.push_back({{}, std::span(indices_).first(3 * count)});
    return choose_joined(meshes, placements_, placed_);
  }

 private:
  std::vector<std::uint32_t> indices_;
  std::vector<std::size_t> counts_;
  std::vector<PlacementView> placements_;
  std::vector<Box3d> placed_;
};

TEST(Joining, takes_every_mesh_that_is_placed_once) {
  Choice choice;
  choice.place(choice.add_mesh(1'000'000), 1);
  choice.place(choice.add_mesh(12), 1);
  choice.place_nothing(1);
  EXPECT_EQ(choice.made(), (std::vector<std::uint32_t>{0, 1}));
}

TEST(Joining, keeps_sharing_what_would_cost_many_copies) {
  Choice choice;
  const std::uint32_t dense = choice.add_mesh(20'000), cube = choice.add_mesh(12);
  choice.place(dense, 10'000);
  choice.place(cube, 100);
  const std::vector<std::uint32_t> made = choice.made();
  ASSERT_EQ(made.size(), 100u);
  EXPECT_EQ(made.front(), 10'000u);

  Choice small;
  small.place(small.add_mesh(1000), 100'000);
  EXPECT_TRUE(small.made().empty());
}

TEST(Joining, leaves_out_what_is_of_another_size) {
  Choice choice;
  const std::uint32_t mesh = choice.add_mesh(12);
  choice.place(mesh, 1, 1e290);
  choice.place(mesh, 3, 1);
  choice.place(mesh, 1, 1e-290);
  choice.place(mesh, 1, 0);
  choice.place(mesh, 1, 1e6);
  EXPECT_EQ(choice.made(), (std::vector<std::uint32_t>{1, 2, 3, 5, 6}));
}

TEST(SceneTree, has_one_tree_for_small_meshes_and_one_entry_for_it_beside_shared_ones) {
  const TestMesh dense(demo::soup(2000).meshes[0]), small(demo::soup(20).meshes[0]);
  const std::vector<MeshView> meshes{small.view(), dense.view()};
  std::vector<PlacementView> placements;
  for (std::uint32_t i = 0; i < 40; ++i) {
    PlacementView& one = placements.emplace_back();
    one.mesh = 0;
    one.world_from_mesh.m[0][3] = i;
  }
  Result<SceneTree> only_small = build_scene_tree(meshes, placements);
  ASSERT_TRUE(only_small.ok());
  EXPECT_EQ(only_small->entries, 1u);
  EXPECT_EQ(only_small->trees.size(), 1u);
  EXPECT_EQ(only_small->placements.size(), 40u);
  EXPECT_EQ(only_small->top.root, ChildRef::kEmpty);
  EXPECT_EQ(only_small->depth, only_small->trees[0]->depth);

  for (std::uint32_t i = 0; i < 600; ++i) {
    PlacementView& one = placements.emplace_back();
    one.mesh = 1;
    one.world_from_mesh.m[1][3] = i;
  }
  Result<SceneTree> both = build_scene_tree(meshes, placements);
  ASSERT_TRUE(both.ok());
  EXPECT_EQ(both->entries, 601u);
  EXPECT_EQ(both->trees.size(), 2u);
  ASSERT_EQ(both->placements.size(), 640u);
  std::vector<TreePart> parts;
  for (std::size_t i = 600; i < 640; ++i) {
    const Placement& placement = both->placements[i];
    EXPECT_EQ(placement.tree, both->placements[600].tree);
    EXPECT_TRUE(placement.world_boxes);
    EXPECT_FALSE(placement.identity) << "its neighbours have matrices";
    EXPECT_EQ(placement.instance, i - 600);
    parts.push_back({meshes[0], &placement.world_from_mesh});
  }
  EXPECT_TRUE(validate_triangle_tree(*both->trees[both->placements[600].tree], parts).ok());
  EXPECT_GE(both->depth, both->top.depth + 1);
}

}  // namespace
}  // namespace sightline
