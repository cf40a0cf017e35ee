// Convex hulls of points against integers: how they lie to triangles, and which points they hold.

#include "core/geometry/convex/point_hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "tests/oracle/hull_distance.h"
#include "tests/oracle/random.h"
#include "tests/oracle/whole_hulls.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

using oracle::Meeting;
using oracle::Whole;

/// Points that are alike, in a line, in a plane or anywhere; some of them twice.
std::vector<Whole> whole_points(oracle::Random& random, int size, const std::vector<Whole>& near) {
  std::vector<Whole> points;
  const std::size_t count = 1 + random.index(random.chance(0.05) ? 14 : 7);
  const int form = random.integer(0, 9);
  const Whole a = oracle::whole_point(random, size), b = oracle::whole_point(random, 2),
              c = oracle::whole_point(random, 2);
  while (points.size() < count) {
    Whole p = oracle::whole_point(random, size);
    if (form <= 2) {  // in a line or a plane
      const int s = random.integer(-3, 3), t = form == 0 ? 0 : random.integer(-3, 3);
      for (std::size_t k = 0; k < 3; ++k) p[k] = a[k] + s * b[k] + t * c[k];
    } else if (form == 3) {  // in an axis-aligned plane, often that of a corner
      p[2] = near[0][2];
    } else if (form == 4) {  // a corner of a box
      for (long long& x : p) x = x < 0 ? -size : size;
    }
    if (random.chance(0.1)) p = near[random.index(near.size())];
    points.push_back(p);
    if (random.chance(0.1)) points.push_back(p);
  }
  return points;
}

std::string described(const std::vector<Whole>& points) {
  std::string text;
  for (const Whole& p : points)
    text +=
        "[" + std::to_string(p[0]) + "," + std::to_string(p[1]) + "," + std::to_string(p[2]) + "] ";
  return text;
}

TEST(PointHull, meets_triangles_and_holds_points_as_integers_say) {
  constexpr std::uint64_t kSeed = 2411;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::size_t apart = 0, touch = 0, overlap = 0, held = 0;
  const int cases = test::random_cases(1000);
  for (int round = 0; round < cases; ++round) {
    const int size = random.integer(1, 9);
    const std::vector<Whole> triangle{oracle::whole_point(random, size),
                                      oracle::whole_point(random, size),
                                      oracle::whole_point(random, size)};
    const std::vector<Whole> points = whole_points(random, size, triangle);
    constexpr int kExponents[] = {0, 0, 0, 300, -300, 1015, -1074};
    const int exponent = kExponents[random.index(std::size(kExponents))];
    std::vector<Vec3d> scaled;
    scaled.reserve(points.size());
    for (const Whole& p : points) scaled.push_back(oracle::scaled(p, exponent));
    const Triangle t{oracle::scaled(triangle[0], exponent), oracle::scaled(triangle[1], exponent),
                     oracle::scaled(triangle[2], exponent)};
    const ConvexHull hull(PointHull{scaled});
    const std::string what = "round " + std::to_string(round) + " hull " + described(points) +
                             "triangle " + described(triangle) + "exponent " +
                             std::to_string(exponent);
    const bool has_area = oracle::cross(oracle::minus(triangle[1], triangle[0]),
                                        oracle::minus(triangle[2], triangle[0])) != oracle::Whole{};
    const Meeting truth = has_area ? oracle::meeting_of(points, triangle) : Meeting::kApart;
    ASSERT_EQ(triangle_meets_box(t, hull), truth != Meeting::kApart) << what;
    const bool is_held = oracle::meeting_of(points, {triangle[0]}) != Meeting::kApart;
    ASSERT_EQ(is_within(t.v0, hull), is_held) << what;
    apart += truth == Meeting::kApart ? 1u : 0u;
    touch += truth == Meeting::kTouch ? 1u : 0u;
    overlap += truth == Meeting::kOverlap ? 1u : 0u;
    held += is_held ? 1u : 0u;
  }
  std::printf("%d hulls: apart %zu, touch %zu, overlap %zu, hold a corner %zu; wrong 0\n", cases,
              apart, touch, overlap, held);
  EXPECT_GT(apart, test::random_cases(100u));
  EXPECT_GT(touch, test::random_cases(100u));
  EXPECT_GT(overlap, test::random_cases(100u));
  EXPECT_GT(held, test::random_cases(50u));
}

TEST(PointHull, of_numbers_between_meets_what_rational_arithmetic_says) {
  oracle::Random random(2412);
  std::size_t meet = 0;
  const int cases = test::random_cases(200);
  for (int round = 0; round < cases; ++round) {
    std::vector<Vec3d> points;
    while (points.size() < 4 + random.index(2)) points.push_back(random.point(-2, 2));
    const Triangle t{random.point(-3, 3), random.point(-3, 3), random.point(-3, 3)};
    std::vector<oracle::ExactPoint> a, b;
    for (const Vec3d& p : points) a.push_back(oracle::exact_point(p));
    for (const Vec3d& p : {t.v0, t.v1, t.v2}) b.push_back(oracle::exact_point(p));
    const bool expected = oracle::hull_square_distance(a, b) == 0;
    ASSERT_EQ(triangle_meets_box(t, ConvexHull(PointHull{points})), expected) << "round " << round;
    meet += expected ? 1u : 0u;
  }
  EXPECT_GT(meet, test::random_cases(30u));
}

/// Many points: of a ball, and of the surface of a cube where most faces have many points.
TEST(PointHull, of_many_points_is_that_of_its_corners) {
  oracle::Random random(2413);
  std::vector<Vec3d> ball, cube;
  for (int i = 0; i < 256; ++i) {
    ball.push_back(random.direction());
    Vec3d p{double(random.integer(0, 8)), double(random.integer(0, 8)),
            double(random.integer(0, 8))};
    p[random.integer(0, 2)] = random.chance(0.5) ? 0 : 8;
    if (i < 8) p = {(i & 1) * 8.0, (i >> 1 & 1) * 8.0, (i >> 2) * 8.0};
    cube.push_back(p);
  }
  const ConvexHull of_ball(PointHull{ball}), of_cube(PointHull{cube}),
      of_corners(PointHull{{cube.data(), 8}});
  for (const Vec3d& p : ball) EXPECT_TRUE(is_within(p, of_ball));
  std::size_t meet = 0;
  for (int round = 0; round < 2000; ++round) {
    const auto corner = [&] {
      return Vec3d{double(random.integer(-4, 12)), double(random.integer(-4, 12)),
                   double(random.integer(-4, 12))};
    };
    const Triangle t{corner(), corner(), corner()};
    const bool expected = triangle_meets_box(t, of_corners);
    ASSERT_EQ(triangle_meets_box(t, of_cube), expected) << "round " << round;
    meet += expected ? 1u : 0u;
    const Vec3d p = random.point(-1.2, 1.2);
    const double length = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    if (length > 1.0001) {
      EXPECT_FALSE(is_within(p, of_ball));
    }
    if (length < 0.75) {
      EXPECT_TRUE(is_within(p, of_ball));
    }
  }
  EXPECT_GT(meet, 200u);
}

TEST(PointHull, touches_and_misses_by_one_unit_in_the_last_place) {
  const Triangle t{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};
  const double above = std::nextafter(0.0, 1.0);
  const auto meets = [&](const std::vector<Vec3d>& points) {
    return triangle_meets_box(t, ConvexHull(PointHull{points}));
  };
  // A point, a segment, a polygon and a tetrahedron with their lowest point on the triangle.
  std::vector<Vec3d> points;
  for (const Vec3d& p : {Vec3d{1, 1, 0}, Vec3d{1, 1, 5}, Vec3d{3, 1, 5}, Vec3d{1, 3, 5}}) {
    points.push_back(p);
    EXPECT_TRUE(meets(points)) << points.size();
    points[0].z = above;
    EXPECT_FALSE(meets(points)) << points.size();
    points[0].z = 0;
  }
  // The long edge x + y = 8 from outside, in the triangle's plane.
  EXPECT_TRUE(meets({{4, 4, 0}, {9, 9, 0}, {9, 8, 0}}));
  EXPECT_FALSE(meets({{4, std::nextafter(4.0, 5.0), 0}, {9, 9, 0}, {9, 8, 0}}));
  EXPECT_FALSE(triangle_meets_box({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, ConvexHull(PointHull{points})))
      << "no area";
}

}  // namespace
}  // namespace sightline
