#include "core/geometry/normal_map.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

Affine matrix(double a, double b, double c, double d, double e, double f, double g, double h,
              double i) {
  return {{{a, b, c, 5}, {d, e, f, 6}, {g, h, i, 7}}};
}

void expect_near(const Vec3d& got, const Vec3d& exact) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(got[k], exact[k], 0x1p-50) << k;
}

TEST(NormalMap, keeps_directions_where_nothing_turns) {
  EXPECT_EQ(NormalMap(Affine{}).apply({0, 0, 4}), (Vec3d{0, 0, 1}));
  EXPECT_EQ(NormalMap(Affine{}).apply({3, 0, -4}), (Vec3d{0.6, 0, -0.8}));
}

TEST(NormalMap, is_the_inverse_transpose) {
  const double root = std::sqrt(21.0);
  // (1,1,1) over (2,1,4) is (2,4,1) / 4.
  expect_near(NormalMap(matrix(2, 0, 0, 0, 1, 0, 0, 0, 4)).apply({1, 1, 1}),
              {2 / root, 4 / root, 1 / root});
  // A mirror turns the normal as it turns every direction.
  expect_near(NormalMap(matrix(-2, 0, 0, 0, 1, 0, 0, 0, 4)).apply({1, 1, 1}),
              {-2 / root, 4 / root, 1 / root});
  // A shear x + y: the plane x = 0 becomes x = y.
  expect_near(NormalMap(matrix(1, 1, 0, 0, 1, 0, 0, 0, 1)).apply({1, 0, 0}),
              {std::sqrt(0.5), -std::sqrt(0.5), 0});
}

TEST(NormalMap, does_not_depend_on_the_scale) {
  const Vec3d once = NormalMap(matrix(1, 2, 3, 0, 1, 4, 5, 6, 0)).apply({1, -2, 0.5});
  for (const double s : {0x1p-1000, 0x1p-100, 0x1p100, 0x1p1000}) {
    EXPECT_EQ(NormalMap(matrix(1 * s, 2 * s, 3 * s, 0, 1 * s, 4 * s, 5 * s, 6 * s, 0))
                  .apply({0x1p-1030, -0x1p-1029, 0x1p-1031}),
              once)
        << s;
  }
}

TEST(NormalMap, knows_a_mirror_by_the_last_bit) {
  // The determinant is e (times 1), which float64 sums lose beside 1e16.
  for (const double e : {1.0, -1.0}) {
    const Affine nearly_flat = matrix(0x1p54, 0x1p54, 0, 0x1p54, 0x1p54 + 4 * e, 0, 0, 0, 1);
    const Vec3d up = NormalMap(nearly_flat).apply({0, 0, 1});
    EXPECT_EQ(up, (Vec3d{0, 0, 1})) << e;
    const Vec3d side = NormalMap(nearly_flat).apply({1, 0, 0});
    EXPECT_EQ(side.x > 0, e > 0);
  }
}

TEST(NormalMap, has_no_direction_for_what_is_flattened_or_no_number) {
  const NormalMap flat(matrix(1, 0, 0, 0, 1, 0, 0, 0, 0));
  EXPECT_EQ(flat.apply({0.5, 0.25, 2}), (Vec3d{0, 0, 1}));
  EXPECT_TRUE(std::isnan(flat.apply({1, 1, 0}).x));
  EXPECT_TRUE(std::isnan(NormalMap(matrix(0, 0, 0, 0, 0, 0, 0, 0, 0)).apply({0, 0, 1}).x));
  EXPECT_TRUE(std::isnan(NormalMap(Affine{}).apply({0, 0, 0}).x));
  const double inf = INFINITY;
  EXPECT_TRUE(std::isnan(NormalMap(Affine{}).apply({0, inf, 1}).x));
  EXPECT_TRUE(std::isnan(NormalMap(Affine{}).apply({0, NAN, 1}).x));
}

}  // namespace
}  // namespace sightline
