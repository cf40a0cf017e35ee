// Where placed meshes lie: the bounds a plan states are those of their triangles, to the bit.

#include "core/bvh/scene_plan.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "core/geometry/triangle.h"

namespace sightline {
namespace {

constexpr float kFar = std::numeric_limits<float>::max();

/// Triangle by triangle.
Box3d bounds_of(const MeshView& mesh, const Affine& matrix) {
  Box3d bounds;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Triangle triangle{matrix.apply(mesh.positions[mesh.indices[i]]),
                            matrix.apply(mesh.positions[mesh.indices[i + 1]]),
                            matrix.apply(mesh.positions[mesh.indices[i + 2]])};
    if (!is_finite(triangle)) continue;
    for (const Vec3d* p : {&triangle.v0, &triangle.v1, &triangle.v2}) bounds.include(*p);
  }
  return bounds;
}

std::vector<Affine> matrices() {
  Affine mirrored, turned, huge, beyond;
  mirrored.m[0][0] = -0.3;
  mirrored.m[1][1] = 1e-310;
  mirrored.m[2][3] = 0.1;
  turned.m[0][1] = 0.7;
  turned.m[2][0] = -0.1;
  huge.m[1][1] = 1e300;
  beyond.m[1][1] = std::numeric_limits<double>::max();
  return {Affine{}, mirrored, turned, huge, beyond};
}

void expect_bounds(const std::vector<Vec3f>& positions, const std::vector<std::uint32_t>& indices) {
  for (const Affine& matrix : matrices()) {
    const MeshView mesh{positions, indices};
    const auto plan = plan_scene({mesh}, {{0, matrix, false}});
    ASSERT_TRUE(plan.ok());
    EXPECT_EQ(plan->placed[0], bounds_of(mesh, matrix));
    EXPECT_EQ(plan->bounds, plan->placed[0]);
  }
}

TEST(ScenePlan, bounds_are_those_of_the_triangles) {
  expect_bounds({{-1, 2, 3}, {4, -0.0f, 6}, {0.1f, 8, -9}, {1, 1, 1e-40f}}, {0, 1, 2, 1, 2, 3});
}

TEST(ScenePlan, bounds_leave_out_positions_that_no_triangle_uses) {
  expect_bounds({{-1, 2, 3}, {kFar, kFar, kFar}, {4, 5, 6}, {7, 8, -9}}, {0, 2, 3});
}

TEST(ScenePlan, bounds_leave_out_triangles_that_are_not_finite_in_the_world) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  // The second triangle leaves float64 under one of the matrices, the third is never finite.
  expect_bounds({{-1, 0.5f, 3}, {4, 0.5f, 6}, {7, 0, -9}, {0, kFar, 0}, {nan, 0, 0}},
                {0, 1, 2, 1, 2, 3, 2, 3, 4});
  expect_bounds({{-1, 0.5f, 3}, {4, 0.5f, 6}, {7, 0, -9}, {0, kFar, 0}}, {0, 1, 2, 1, 2, 3});
}

/// A mesh with unused positions, placed often under many maps: turned, sheared, flattened, far away.
TEST(ScenePlan, bounds_of_many_placements_are_exact) {
  std::mt19937_64 random(9);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; };
  std::vector<Vec3f> positions;
  positions.reserve(300);
  for (int i = 0; i < 300; ++i) {
    positions.push_back({static_cast<float>(unit()), static_cast<float>(unit()),
                         static_cast<float>(unit() * (i % 3))});
  }
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i + 2 < 290; ++i) indices.insert(indices.end(), {i, i + 1, i + 2});
  positions[295] = {kFar, kFar, kFar};
  const MeshView mesh{positions, indices};
  for (const int kind : {0, 1, 2, 3}) {
    std::vector<PlacementView> placements;
    Box3d expected;
    std::vector<Box3d> each;
    for (int i = 0; i < 200; ++i) {
      Affine matrix;
      for (auto& row : matrix.m) {
        for (double& x : row) x = unit() * (kind == 1 ? 1e8 : 1);
      }
      if (kind == 2) matrix.m[i % 3][i % 3] = 0;
      if (kind == 3 && i % 7 == 0) matrix.m[1][1] = std::numeric_limits<double>::max();
      if (i % 11 == 0) matrix = Affine{};
      placements.push_back({0, matrix, i % 13 == 0});
      each.push_back(i % 13 == 0 ? Box3d{} : bounds_of(mesh, matrix));
      expected.include(each.back());
    }
    auto plan = plan_scene({mesh}, placements);
    ASSERT_TRUE(plan.ok());
    EXPECT_EQ(plan->bounds, expected) << kind;
    int loose = 0;
    for (std::size_t i = 0; i < placements.size(); ++i) {
      loose += plan->is_loose[i];
      EXPECT_EQ(plan->exact_bounds(i, 1), each[i]) << kind << " " << i;
      Box3d both = plan->placed[i];
      both.include(each[i]);
      EXPECT_EQ(both, plan->placed[i]);
    }
    EXPECT_GT(loose, 100);
    // Then some of them move.
    std::vector<MovedPlacement> moved;
    for (std::uint32_t i = 0; i < 200; i += 9)
      moved.push_back({i, placements[(i + 50) % 200].world_from_mesh, i % 2 == 0});
    const ScenePlan later = *moved_plan(*plan, moved);
    for (const MovedPlacement& one : moved)
      each[one.number] = one.hidden ? Box3d{} : bounds_of(mesh, one.world_from_mesh);
    expected = {};
    for (const Box3d& box : each) expected.include(box);
    EXPECT_EQ(later.bounds, expected) << kind;
  }
}

}  // namespace
}  // namespace sightline
