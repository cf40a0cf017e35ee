// Large meshes in parts: each triangle in one of them, inside its box.

#include "core/bvh/split.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>

#include "core/bvh/tree_corners.h"
#include "core/bvh/validate.h"
#include "tests/unit/scene/small_scenes.h"

namespace sightline {
namespace {

using test::description_of;

Box3d bounds_of(const MeshView& mesh, const Affine* matrix) {
  Box3d bounds;
  for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
    const TreeCorners corners = tree_corners(mesh, i, matrix);
    if (!corners.usable) continue;
    for (const Vec3d& p : corners.at) bounds.include(p);
  }
  return bounds;
}

void expect_partition(const MeshView& mesh, const Affine* matrix,
                      const std::vector<MeshPart>& parts) {
  std::vector<int> seen(mesh.triangle_count());
  for (const MeshPart& part : parts) {
    EXPECT_EQ(part.triangle_count, numbers_of(part.runs).size());
    for (const std::uint32_t triangle : numbers_of(part.runs)) {
      ++seen[triangle];
      for (const Vec3d& p : tree_corners(mesh, triangle, matrix).at) {
        for (int k = 0; k < 3; ++k) {
          EXPECT_LE(part.box.min[k], p[k]);
          EXPECT_GE(part.box.max[k], p[k]);
        }
      }
    }
  }
  for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
    EXPECT_EQ(seen[i], tree_corners(mesh, i, matrix).usable ? 1 : 0) << i;
  }
}

TEST(Split, puts_every_triangle_into_one_part) {
  const SceneDescription description = description_of(demo::terrain(200000));
  const MeshView mesh{description.meshes[0]->positions, description.meshes[0]->indices};
  const auto parts = split_mesh(mesh, nullptr, {}, bounds_of(mesh, nullptr));
  EXPECT_GE(parts.size(), 12u);
  for (const MeshPart& part : parts) EXPECT_LE(part.triangle_count, kPartTriangles);
  expect_partition(mesh, nullptr, parts);
  Affine matrix;
  matrix.m[0][1] = 1e200;
  matrix.m[2][2] = 1e-200;
  expect_partition(mesh, &matrix, split_mesh(mesh, &matrix, {}, bounds_of(mesh, &matrix)));
}

TEST(Split, cuts_a_part_of_a_mesh_again) {
  const SceneDescription description = description_of(demo::soup(100000));
  const MeshView mesh{description.meshes[0]->positions, description.meshes[0]->indices};
  const auto parts = split_mesh(mesh, nullptr, {}, bounds_of(mesh, nullptr));
  std::vector<int> seen(mesh.triangle_count());
  for (const MeshPart& part : parts) {
    const auto smaller = split_mesh(mesh, nullptr, numbers_of(part.runs), part.box);
    for (const MeshPart& one : smaller) {
      for (const std::uint32_t triangle : numbers_of(one.runs)) ++seen[triangle];
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), mesh.triangle_count());
}

TEST(Split, leaves_together_what_lies_in_one_place_and_drops_what_nothing_hits) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Vec3f> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}};
  std::vector<std::uint32_t> indices;
  for (int i = 0; i < 50; ++i) indices.insert(indices.end(), {0, 1, 2, 0, 1, 3, 0, 0, 1});
  const auto parts = split_mesh({positions, indices}, nullptr, {}, {{0, 0, 0}, {1, 1, 0}});
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].triangle_count, 50u);
  EXPECT_TRUE(split_mesh({positions, {}}, nullptr, {}, {}).empty());
}

TEST(Split, builds_a_tree_that_names_triangles_by_their_number_in_the_mesh) {
  const SceneDescription description = description_of(demo::terrain(2000));
  const MeshView mesh{description.meshes[0]->positions, description.meshes[0]->indices};
  const std::vector<TriangleRun> runs{{3, 1}, {5, 700}, {900, 1100}};
  const TreePart part{mesh, nullptr, runs};
  const WideTree tree = build_triangle_tree({&part, 1}, TreeQuality::kFast);
  EXPECT_TRUE(validate_triangle_tree(tree, {&part, 1}));
  const Status all = validate_triangle_tree(tree, mesh, nullptr);
  ASSERT_FALSE(all);
  const std::vector<TriangleRun> fewer{{5, 700}, {900, 1100}};
  const TreePart other{mesh, nullptr, fewer};
  EXPECT_FALSE(validate_triangle_tree(tree, {&other, 1}));
}

TEST(Split, names_triangles_that_are_far_apart) {
  // Neighbours in space whose numbers differ by more than a leaf block can express. The indices of
  // the triangles between them are zeros that nothing reads, so they take no memory.
  constexpr std::uint32_t kDistant = LeafBlock::kNear + 10;
  const std::vector<Vec3f> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  constexpr std::size_t kIndices = std::size_t{3} * (kDistant + 2);
  const std::unique_ptr<void, void (*)(void*)> memory(std::calloc(kIndices, 4), &std::free);
  const std::span<std::uint32_t> indices(static_cast<std::uint32_t*>(memory.get()), kIndices);
  const auto set = [&](std::uint32_t triangle, std::array<std::uint32_t, 3> corners) {
    std::copy(corners.begin(), corners.end(), indices.begin() + std::ptrdiff_t{3} * triangle);
  };
  set(1, {0, 1, 2});
  set(kDistant, {1, 3, 2});
  set(kDistant + 1, {0, 2, 3});
  const MeshView mesh{positions, std::span<const std::uint32_t>(indices)};
  const std::vector<TriangleRun> runs{{1, 1}, {kDistant, 2}};
  const TreePart part{mesh, nullptr, runs};
  const WideTree tree = build_triangle_tree({&part, 1}, TreeQuality::kHigh);
  EXPECT_TRUE(validate_triangle_tree(tree, {&part, 1}));
  EXPECT_EQ(tree.block_count, 2u);
}

TEST(Split, cuts_a_mesh_into_parts_of_a_limited_size) {
  const SceneDescription description = description_of(demo::terrain(50000));
  const MeshView mesh{description.meshes[0]->positions, description.meshes[0]->indices};
  MeshPart whole;
  whole.box = bounds_of(mesh, nullptr);
  for (const std::uint32_t most : {100u, 5000u, 20000u}) {
    const auto cells = cut_mesh(mesh, nullptr, whole, most);
    expect_partition(mesh, nullptr, cells);
    EXPECT_GE(cells.size(), mesh.triangle_count() / most);
    for (const MeshPart& cell : cells) {
      EXPECT_LE(cell.triangle_count, most);
      for (std::size_t i = 1; i < cell.runs.size(); ++i)
        EXPECT_GT(cell.runs[i].first, cell.runs[i - 1].first + cell.runs[i - 1].count);
    }
  }
  // Its cells are neighbours: few of their boxes meet.
  const auto cells = cut_mesh(mesh, nullptr, whole, 5000);
  EXPECT_LE(cells.size(), 20u);
}

TEST(Split, cuts_triangles_in_one_place_by_number) {
  const std::vector<Vec3f> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  std::vector<std::uint32_t> indices;
  for (int i = 0; i < 50; ++i) indices.insert(indices.end(), {0, 1, 2, 0, 0, 1});
  const MeshView mesh{positions, indices};
  MeshPart whole;
  whole.box = bounds_of(mesh, nullptr);
  const auto cells = cut_mesh(mesh, nullptr, whole, 7);
  EXPECT_EQ(cells.size(), 8u);
  expect_partition(mesh, nullptr, cells);
}

}  // namespace
}  // namespace sightline
