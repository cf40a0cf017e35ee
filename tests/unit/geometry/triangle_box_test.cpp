#include "core/geometry/triangle_box.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/infinity.h"

namespace sightline {
namespace {

constexpr Box3d kCube{{-2, -3, -4}, {4, 3, 2}};

double above(double x) { return std::nextafter(x, kInf); }

TEST(TriangleBox, meets_what_reaches_inside) {
  EXPECT_TRUE(triangle_meets_box({{0, 0, 0}, {9, 0, 0}, {0, 9, 0}}, kCube));
  EXPECT_TRUE(triangle_meets_box({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, kCube)) << "all inside";
  EXPECT_TRUE(triangle_meets_box({{-99, -99, 0}, {99, -99, 0}, {0, 99, 0}}, kCube)) << "around it";
  EXPECT_TRUE(triangle_meets_box({{-9, 0, 0}, {9, 0, 0}, {0, 9, 50}}, kCube))
      << "an edge through it";
}

TEST(TriangleBox, keeps_a_triangle_that_touches_a_face_an_edge_or_a_corner) {
  EXPECT_TRUE(triangle_meets_box({{4, 0, 0}, {9, 1, 0}, {9, 0, 1}}, kCube)) << "corner in a face";
  EXPECT_TRUE(triangle_meets_box({{4, 3, 0}, {9, 9, 0}, {9, 9, 1}}, kCube)) << "corner on an edge";
  EXPECT_TRUE(triangle_meets_box({{4, 3, 2}, {9, 9, 9}, {9, 9, 8}}, kCube)) << "corner on a corner";
  EXPECT_TRUE(triangle_meets_box({{5, 2, 0}, {3, 4, 0}, {9, 9, 0}}, kCube)) << "edge on an edge";
  EXPECT_TRUE(triangle_meets_box({{4, 0, 0}, {4, 9, 0}, {4, 0, 9}}, kCube)) << "in a face's plane";
  EXPECT_TRUE(triangle_meets_box({{9, 0, 0}, {0, 9, 0}, {0, 0, 9}}, kCube)) << "through the corner";
}

TEST(TriangleBox, leaves_a_triangle_that_passes_by_one_number) {
  EXPECT_FALSE(triangle_meets_box({{above(4), 0, 0}, {9, 1, 0}, {9, 0, 1}}, kCube));
  EXPECT_FALSE(triangle_meets_box({{4, above(3), 0}, {9, 9, 0}, {9, 9, 1}}, kCube));
  EXPECT_FALSE(triangle_meets_box({{above(5), 2, 0}, {3, 4, 0}, {9, 9, 0}}, kCube));
  EXPECT_FALSE(triangle_meets_box({{above(9), 0, 0}, {0, above(9), 0}, {0, 0, above(9)}}, kCube));
}

TEST(TriangleBox, leaves_a_triangle_that_only_its_plane_or_its_bounds_bring_near) {
  EXPECT_FALSE(triangle_meets_box({{10, 0, 0}, {0, 10, 0}, {0, 0, 10}}, kCube)) << "its plane";
  EXPECT_FALSE(triangle_meets_box({{3.5, 9, 0}, {9, 2.5, 0}, {9, 9, 0}}, kCube)) << "an edge";
}

TEST(TriangleBox, drops_triangles_without_area_and_non_finite_ones) {
  EXPECT_FALSE(triangle_meets_box({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, kCube));
  EXPECT_FALSE(triangle_meets_box({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, kCube));
  EXPECT_FALSE(triangle_meets_box({{kInf, 0, 0}, {1, 0, 0}, {0, 1, 0}}, kCube));
}

TEST(TriangleBox, takes_points_plates_and_open_boxes) {
  const Triangle triangle{{0, 0, 0}, {4, 0, 0}, {0, 4, 4}};
  const Vec3d inside{1, 1, 1}, beside{1, 1, above(1)};
  EXPECT_TRUE(triangle_meets_box(triangle, Box3d{inside, inside}));
  EXPECT_FALSE(triangle_meets_box(triangle, Box3d{beside, beside}));
  EXPECT_TRUE(triangle_meets_box(triangle, Box3d{{-9, 1, -9}, {9, 1, 9}}));
  EXPECT_TRUE(triangle_meets_box(triangle, Box3d{{-kInf, 4, -kInf}, {kInf, kInf, kInf}}));
  EXPECT_FALSE(triangle_meets_box(triangle, Box3d{{-kInf, above(4), -kInf}, {kInf, kInf, kInf}}));
  EXPECT_TRUE(triangle_meets_box(triangle, Box3d{{-kInf, -kInf, -kInf}, {kInf, kInf, kInf}}));
}

TEST(TriangleBox, takes_oriented_boxes_by_their_slabs) {
  // |x + y| <= 1, |x - y| <= 1, |z| <= 1: a diamond with corners at x = +-1 and y = +-1.
  const OrientedBox diamond{{0, 0, 0}, {1, 1, 1}, {{{1, 1, 0}, {1, -1, 0}, {0, 0, 1}}}};
  EXPECT_TRUE(triangle_meets_box({{1, 0, 0}, {5, 1, 0}, {5, 0, 1}}, diamond));
  EXPECT_FALSE(triangle_meets_box({{above(1), 0, 0}, {5, 1, 0}, {5, 0, 1}}, diamond));
  EXPECT_TRUE(triangle_meets_box({{0, 1, 0}, {1, 0, 0}, {3, 3, 3}}, diamond))
      << "an edge in a face";
  EXPECT_FALSE(triangle_meets_box({{0.75, 0.75, 0}, {5, 0.75, 0}, {5, 5, 1}}, diamond))
      << "inside its bounds, not in it";
}

TEST(TriangleBox, needs_no_epsilon_at_any_scale) {
  for (const int exponent : {-1000, -100, -20, 0, 20, 100, 900}) {
    const auto at = [&](double x, double y, double z) {
      return Vec3d{std::ldexp(x, exponent), std::ldexp(y, exponent), std::ldexp(z, exponent)};
    };
    const Box3d box{at(-2, -3, -4), at(4, 3, 2)};
    EXPECT_TRUE(triangle_meets_box({at(9, 0, 0), at(0, 9, 0), at(0, 0, 9)}, box)) << exponent;
    EXPECT_FALSE(
        triangle_meets_box({at(above(9), 0, 0), at(0, 9, 0), at(0, 0, 9)}, box) &&
        triangle_meets_box({at(above(9), 0, 0), at(0, above(9), 0), at(0, 0, above(9))}, box))
        << exponent;
  }
}

TEST(TriangleBox, decides_a_corner_within_without_big_numbers) {
  // Edges along the axes: the box that is cut to the triangle touches its corners.
  const Triangle wall{{1, 1, 1}, {1, 3, 1}, {1, 1, 4}};
  const double inf = Box3d::kInf;
  EXPECT_EQ(filter_triangle_box(wall, Box3d{{-inf, -inf, -inf}, {inf, inf, inf}}),
            OverlapVerdict::kMeet);
  EXPECT_EQ(filter_triangle_box(wall, Box3d{{0, 0, 0}, {9, 9, 9}}), OverlapVerdict::kMeet);
  EXPECT_EQ(filter_triangle_box(wall, Box3d{{1, 2, 0}, {1, 9, 9}}), OverlapVerdict::kMeet);
  EXPECT_EQ(filter_triangle_box(wall, OrientedBox{{2, 2, 2}, {5, 5, 5}, rotated_axes(0, 0, 0, 1)}),
            OverlapVerdict::kMeet);
  // Without an area it is no part of a scene, wherever its corners are.
  const Triangle line{{1, 1, 1}, {2, 2, 2}, {3, 3, 3}};
  EXPECT_EQ(filter_triangle_box(line, Box3d{{0, 0, 0}, {9, 9, 9}}), OverlapVerdict::kOpen);
  EXPECT_FALSE(triangle_meets_box(line, Box3d{{0, 0, 0}, {9, 9, 9}}));
}

TEST(TriangleBox, decides_ordinary_pairs_without_big_numbers) {
  EXPECT_EQ(filter_triangle_box({{0, 0, 0}, {9, 0, 0}, {0, 9, 0}}, kCube), OverlapVerdict::kMeet)
      << "flat triangles too";
  EXPECT_EQ(filter_triangle_box({{3, 9, 0.5}, {9, 2, 0}, {9, 9, 0.25}}, kCube),
            OverlapVerdict::kApart);
  EXPECT_EQ(filter_triangle_box({{9, 0, 0}, {0, 9, 0}, {0, 0, 9}}, kCube), OverlapVerdict::kOpen);
}

}  // namespace
}  // namespace sightline
