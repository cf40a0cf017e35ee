// Where placed meshes lie: the bounds a plan states are those of their triangles, to the bit.

#include "core/bvh/scene_plan.h"

#include <gtest/gtest.h>

#include <limits>
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

}  // namespace
}  // namespace sightline
