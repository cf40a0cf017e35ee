#include "core/import/gltf/transform.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline::gltf {
namespace {

Result<Affine> matrix_of(const tinygltf::Node& node) {
  std::string warning;
  return node_matrix(node, 3, warning);
}

TEST(FromTrs, is_the_identity_for_the_identity) {
  EXPECT_TRUE(from_trs({0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}).is_identity());
}

TEST(FromTrs, scales_first_then_turns_then_moves) {
  // A quarter turn about +z, exactly: (0, 0, 1, 1) is not of unit length but this is taken as it
  // stands; with s = sqrt(1/2) the products are 0.5 within rounding.
  const double h = std::sqrt(0.5);
  const Affine m = from_trs({10, 20, 30}, {0, 0, h, h}, {2, 3, 4});
  const Vec3d p = m.apply(Vec3d{1, 1, 1});
  EXPECT_NEAR(p.x, 10 - 3, 1e-14);
  EXPECT_NEAR(p.y, 20 + 2, 1e-14);
  EXPECT_EQ(p.z, 34);
}

TEST(FromTrs, follows_the_documented_order_of_operations) {
  const double x = 0.1, y = -0.7, z = 0.3, w = 0.64;
  const Affine m = from_trs({1, 2, 3}, {x, y, z, w}, {5, 7, 11});
  const double x2 = x + x, y2 = y + y, z2 = z + z;
  EXPECT_EQ(m.m[0][0], (1 - (y * y2 + z * z2)) * 5);
  EXPECT_EQ(m.m[0][1], (x * y2 - w * z2) * 7);
  EXPECT_EQ(m.m[0][2], (x * z2 + w * y2) * 11);
  EXPECT_EQ(m.m[1][0], (x * y2 + w * z2) * 5);
  EXPECT_EQ(m.m[1][1], (1 - (x * x2 + z * z2)) * 7);
  EXPECT_EQ(m.m[1][2], (y * z2 - w * x2) * 11);
  EXPECT_EQ(m.m[2][0], (x * z2 - w * y2) * 5);
  EXPECT_EQ(m.m[2][1], (y * z2 + w * x2) * 7);
  EXPECT_EQ(m.m[2][2], (1 - (x * x2 + y * y2)) * 11);
  EXPECT_EQ(m.m[0][3], 1);
  EXPECT_EQ(m.m[1][3], 2);
  EXPECT_EQ(m.m[2][3], 3);
}

TEST(NodeMatrix, reads_a_matrix_by_columns) {
  tinygltf::Node node;
  node.matrix = {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 10, 11, 12, 1};
  const auto m = matrix_of(node);
  ASSERT_TRUE(m.ok());
  EXPECT_EQ(m->m[0][3], 10);
  EXPECT_EQ(m->m[1][0], 2);
  EXPECT_EQ(m->m[2][1], 6);
}

TEST(NodeMatrix, refuses_a_last_row_that_projects) {
  tinygltf::Node node;
  node.matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1};
  EXPECT_EQ(matrix_of(node).error().code, "GLTF_TRANSFORM_INVALID");
  EXPECT_EQ(matrix_of(node).error().pointer, "/nodes/3/matrix");
}

TEST(NodeMatrix, refuses_a_rotation_of_zero_and_warns_of_an_unlikely_one) {
  tinygltf::Node node;
  node.rotation = {0, 0, 0, 0};
  EXPECT_FALSE(matrix_of(node).ok());
  node.rotation = {0, 0, 0, 2};
  std::string warning;
  ASSERT_TRUE(node_matrix(node, 3, warning).ok());
  EXPECT_NE(warning.find("node 3"), std::string::npos);
  warning.clear();
  node.rotation = {0, 0, 0, 1.001};
  ASSERT_TRUE(node_matrix(node, 3, warning).ok());
  EXPECT_EQ(warning, "");
}

TEST(NodeMatrix, keeps_to_the_range_of_float32) {
  tinygltf::Node node;
  node.translation = {3.4e38, 0, 0};
  EXPECT_TRUE(matrix_of(node).ok());
  node.translation = {3.5e38, 0, 0};
  EXPECT_FALSE(matrix_of(node).ok());
}

}  // namespace
}  // namespace sightline::gltf
