// Triangles and balls against rational arithmetic.

#include "core/geometry/triangle_sphere.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/oracle/exact_triangle.h"
#include "tests/oracle/nearest_point.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

TEST(TriangleSphere, is_what_rational_arithmetic_says) {
  constexpr std::uint64_t kSeed = 66;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::size_t meet = 0, apart = 0, touch = 0;
  for (int round = 0; round < test::random_cases(30000); ++round) {
    // On a grid many of them touch exactly: distances of 3, 4, 5, 13 are common.
    const bool is_grid = random.chance(0.7);
    const double scale = std::ldexp(1.0, random.chance(0.3) ? random.integer(-300, 300) : 0);
    const auto x = [&] {
      return (is_grid ? random.integer(-6, 6) : random.between(-6, 6)) * scale;
    };
    Triangle t{{x(), x(), x()}, {x(), x(), x()}, {x(), x(), x()}};
    Sphere sphere{{x(), x(), x()}, (is_grid ? random.integer(0, 8) : random.between(0, 8)) * scale};
    if (random.chance(0.3)) {  // flat, and touched where the center is above it
      t.v0.z = t.v1.z = t.v2.z = 0;
      sphere.radius = std::fabs(sphere.center.z);
    }
    const oracle::Triangle same{t.v0, t.v1, t.v2};
    const mpq_class square = mpq_class(sphere.radius) * mpq_class(sphere.radius);
    bool expected = false;
    if (!oracle::has_no_area(same)) {
      const mpq_class distance = oracle::nearest(sphere.center, same).square;
      expected = distance <= square;
      touch += distance == square ? 1u : 0u;
    }
    ASSERT_EQ(triangle_meets_box(t, sphere), expected) << "round " << round;
    (expected ? meet : apart) += 1;
  }
  std::printf("meet %zu, apart %zu, touch exactly %zu\n", meet, apart, touch);
  EXPECT_GT(meet, test::random_cases(3000u));
  EXPECT_GT(apart, test::random_cases(3000u));
  EXPECT_GT(touch, test::random_cases(300u));
}

TEST(TriangleSphere, touches_a_plane_an_edge_and_a_corner) {
  const Triangle t{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};
  for (const auto& [center, distance] :
       {std::pair{Vec3d{1, 1, 5}, 5.0}, {Vec3d{4, -3, 4}, 5.0}, {Vec3d{-3, -4, 12}, 13.0}}) {
    EXPECT_TRUE(triangle_meets_box(t, Sphere{center, distance}));
    EXPECT_FALSE(triangle_meets_box(t, Sphere{center, std::nextafter(distance, 0.0)}));
  }
  EXPECT_TRUE(triangle_meets_box(t, Sphere{{1, 1, 0}, 0})) << "a point on it";
  EXPECT_FALSE(triangle_meets_box(t, Sphere{{1, 1, 5e-324}, 0}));
  EXPECT_FALSE(triangle_meets_box({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, Sphere{{1, 1, 1}, 9}))
      << "no area";
}

}  // namespace
}  // namespace sightline
