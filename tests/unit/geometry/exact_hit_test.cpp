#include "core/geometry/exact_hit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/base/infinity.h"
#include "core/base/split_mix.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline {
namespace {

const Triangle kTriangle{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};

double t_of(const Vec3d& o, const Vec3d& d, const Triangle& triangle, double tmin = 0,
            double tmax = kInf) {
  ExactT t;
  return exact_hit(o, d, tmin, tmax, triangle, t) ? t.rounded() : kInf;
}

TEST(ExactHit, meets_the_inside_from_both_sides) {
  EXPECT_EQ(t_of({1, 1, 5}, {0, 0, -1}, kTriangle), 5);
  EXPECT_EQ(t_of({1, 1, -5}, {0, 0, 2}, kTriangle), 2.5);
}

TEST(ExactHit, keeps_edges_and_corners) {
  EXPECT_EQ(t_of({2, 0, 1}, {0, 0, -1}, kTriangle), 1);
  EXPECT_EQ(t_of({2, 2, 1}, {0, 0, -1}, kTriangle), 1);
  EXPECT_EQ(t_of({4, 0, 1}, {0, 0, -1}, kTriangle), 1);
  EXPECT_EQ(t_of({0, -0.0, 1}, {-0.0, 0, -1}, kTriangle), 1);
  EXPECT_EQ(t_of({std::nextafter(4.0, 5.0), 0, 1}, {0, 0, -1}, kTriangle), kInf);
  EXPECT_EQ(t_of({2, -std::numeric_limits<double>::denorm_min(), 1}, {0, 0, -1}, kTriangle), kInf);
}

TEST(ExactHit, closes_the_limits) {
  EXPECT_EQ(t_of({1, 1, 5}, {0, 0, -1}, kTriangle, 5, 5), 5);
  EXPECT_EQ(t_of({1, 1, 5}, {0, 0, -1}, kTriangle, std::nextafter(5.0, 6.0), kInf), kInf);
  EXPECT_EQ(t_of({1, 1, 5}, {0, 0, -1}, kTriangle, 0, std::nextafter(5.0, 4.0)), kInf);
  EXPECT_EQ(t_of({1, 1, -5}, {0, 0, -1}, kTriangle, -kInf, 0), -5);
}

TEST(ExactHit, meets_a_coplanar_triangle_where_the_ray_enters) {
  EXPECT_EQ(t_of({-1, 1, 0}, {1, 0, 0}, kTriangle), 1);
  EXPECT_EQ(t_of({5, 1, 0}, {-2, 0, 0}, kTriangle), 1);
  EXPECT_EQ(t_of({1, 1, 0}, {1, 0, 0}, kTriangle), 0) << "from inside it is met at once";
  EXPECT_EQ(t_of({1, 1, 0}, {1, 0, 0}, kTriangle, 1.5, kInf), 1.5);
  EXPECT_EQ(t_of({1, 1, 0}, {1, 0, 0}, kTriangle, 2.5, kInf), kInf);
  EXPECT_EQ(t_of({-1, 0, 0}, {1, 0, 0}, kTriangle), 1) << "along an edge";
  EXPECT_EQ(t_of({-1, 5, 0}, {1, -1, 0}, kTriangle), 1) << "along the slanted edge";
  EXPECT_EQ(t_of({-1, 4, 0}, {1, 0, 0}, kTriangle), 1) << "touching one corner";
  EXPECT_EQ(t_of({-1, 4.5, 0}, {1, 0, 0}, kTriangle), kInf);
  EXPECT_EQ(t_of({-1, 1, 1e-300}, {1, 0, 0}, kTriangle), kInf) << "parallel, but not in the plane";
}

TEST(ExactHit, finds_coplanar_hits_by_integers_as_by_wide_numbers) {
  SplitMix random(11);
  const auto small = [&] { return static_cast<double>(random.bits() % 9) - 4; };
  int hits = 0, misses = 0, at_corners = 0;
  for (int i = 0; i < 100'000; ++i) {
    // A plane u x + v y through a point, where u and v are exact sums of small multiples.
    const double scale = std::ldexp(1.0, static_cast<int>(random.bits() % 5) * 20 - 40);
    const Vec3d o{small(), small(), small()}, u{small(), small(), small()},
        v{small(), small(), small()};
    const auto at = [&](double x, double y) {
      return Vec3d{(o.x + x * u.x + y * v.x) * scale, (o.y + x * u.y + y * v.y) * scale,
                   (o.z + x * u.z + y * v.z) * scale};
    };
    const Triangle triangle{at(small(), small()), at(small(), small()), at(small(), small())};
    const Vec3d origin = at(small(), small()), end = at(small(), small());
    const Vec3d direction{end.x - origin.x, end.y - origin.y, end.z - origin.z};
    if (direction == Vec3d{}) continue;
    const double tmin = random.bits() % 2 == 0 ? 0 : small() / 2;
    const double tmax = random.bits() % 2 == 0 ? kInf : tmin + 0.75;
    const SharedHit shared = shared_hit(origin, direction, triangle);
    ASSERT_TRUE(shared);
    ExactHit by_integers, by_wide;
    const bool met = exact_hit(origin, direction, tmin, tmax, triangle, shared, by_integers);
    ASSERT_EQ(met, exact_hit(origin, direction, tmin, tmax, triangle, SharedHit{}, by_wide)) << i;
    ++(met ? hits : misses);
    if (!met) continue;
    ASSERT_EQ(compare(by_integers.t, by_wide.t), 0) << i;
    at_corners += is_on_edge(origin, direction, triangle, by_integers.t) ? 1 : 0;
  }
  EXPECT_GT(hits, 10'000);
  EXPECT_GT(misses, 10'000);
  EXPECT_GT(at_corners, 1000);
}

TEST(ExactHit, drops_triangles_without_area_and_non_finite_ones) {
  EXPECT_EQ(t_of({1, 0, 5}, {0, 0, -1}, {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}), kInf);
  EXPECT_EQ(t_of({0, 0, 5}, {0, 0, -1}, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}), kInf);
  EXPECT_EQ(t_of({1, 1, 5}, {0, 0, -1}, {{0, 0, 0}, {kInf, 0, 0}, {0, 4, 0}}), kInf);
  EXPECT_TRUE(is_degenerate({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}));
  EXPECT_FALSE(is_degenerate({{0, 0, 0}, {1, 1, 1}, {3, 3, std::nextafter(3.0, 4.0)}}));
}

TEST(ExactHit, keeps_its_word_at_every_scale) {
  for (const double s : {1e-300, 1e-40, 1e-6, 1e6, 1e30, 1e300}) {
    const Triangle triangle{{0, 0, 0}, {4 * s, 0, 0}, {0, 4 * s, 0}};
    EXPECT_EQ(t_of({s, s, s}, {0, 0, -1}, triangle), s);
    EXPECT_EQ(t_of({2 * s, 2 * s, s}, {0, 0, -s}, triangle), 1) << "on the slanted edge";
    EXPECT_EQ(t_of({std::nextafter(2 * s, kInf), 2 * s, s}, {0, 0, -s}, triangle), kInf);
  }
}

TEST(ExactHit, agrees_with_the_oracle_beside_edges_and_at_the_ends_of_the_range) {
  SplitMix random(7);
  constexpr std::array<int, 7> kExponents{-1074, -1022, -500, 0, 0, 500, 1000};
  int hits = 0;
  for (int i = 0; i < 50'000; ++i) {
    // Few different numbers: many rays pass exactly through edges, or beside them by one bit.
    const int exponent = kExponents[random.bits() % kExponents.size()];
    const auto number = [&] {
      const double whole = std::ldexp(static_cast<double>(random.bits() % 9) - 4, exponent);
      return random.bits() % 4 == 0 ? std::nextafter(whole, kInf) : whole;
    };
    const auto point = [&] { return Vec3d{number(), number(), number()}; };
    const Triangle triangle{point(), point(), point()};
    Ray ray;
    ray.origin = point();
    for (int k = 0; k < 3; ++k) ray.direction[k] = static_cast<double>(random.bits() % 7) - 3;
    if (i % 3 == 0) ray.direction.x = std::nextafter(ray.direction.x, kInf);
    if (ray.direction == Vec3d{0, 0, 0}) continue;
    ray.tmin = random.bits() % 2 == 0 ? 0 : -kInf;
    const oracle::Triangle same{triangle.v0, triangle.v1, triangle.v2};
    const auto truth = oracle::least_t(ray, same);
    ExactT t;
    ASSERT_EQ(exact_hit(ray.origin, ray.direction, ray.tmin, kInf, triangle, t), truth.has_value())
        << i;
    if (!truth) continue;
    ++hits;
    EXPECT_EQ(t.rounded(), oracle::round_to_double(*truth)) << i;
  }
  EXPECT_GT(hits, 1000);
}

TEST(ExactHit, details_are_rounded_once) {
  const Triangle triangle{{0, 0, 1}, {3, 0, 1}, {0, 3, 1}};
  const Vec3d origin{1, 1, 0};
  const Vec3d direction{0, 0, 3};
  ExactT t;
  ASSERT_TRUE(exact_hit(origin, direction, 0, kInf, triangle, t));
  EXPECT_EQ(t.rounded(), 1.0 / 3.0);
  const ExactDetail detail = exact_detail(origin, direction, triangle, t);
  EXPECT_EQ(detail.position, (Vec3d{1, 1, 1})) << "t is rounded, the position must not feel it";
  EXPECT_EQ(detail.normal, (Vec3d{0, 0, 1}));
  EXPECT_EQ(detail.u, 1.0 / 3.0);
  EXPECT_EQ(detail.v, 1.0 / 3.0);
  EXPECT_FALSE(detail.front);
}

/// The corner or edge that exact_hit names; 8: no hit.
CornerSet edge_met(const Vec3d& o, const Vec3d& d, const Triangle& triangle, double tmin = 0) {
  ExactHit hit;
  return exact_hit(o, d, tmin, kInf, triangle, shared_hit(o, d, triangle), hit) ? hit.edge : 8;
}

TEST(ExactHit, names_the_edge_or_corner_that_is_met) {
  const Triangle triangle{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const auto met = [&](double x, double y) {
    return edge_met({x + 1, y + 2, 3}, {-1, -2, -3}, triangle);
  };
  EXPECT_EQ(met(0, 0), 1u);
  EXPECT_EQ(met(4, 0), 2u);
  EXPECT_EQ(met(0, 4), 4u);
  EXPECT_EQ(met(1, 0), 3u);
  EXPECT_EQ(met(3, 1), 6u);
  EXPECT_EQ(met(0, 3), 5u);
  EXPECT_EQ(met(1, 1), 0u) << "inside";
  EXPECT_EQ(met(5, 0), 8u) << "on the edge's line, beyond its end";
  EXPECT_EQ(met(0, 0x1p-50), 5u);
  EXPECT_EQ(met(-0x1p-50, 0), 8u);
}

TEST(ExactHit, names_where_a_ray_in_the_plane_enters) {
  const Triangle triangle{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  EXPECT_EQ(edge_met({-1, 1, 0}, {1, 0, 0}, triangle), 5u);
  EXPECT_EQ(edge_met({3, 2, 0}, {-1, 0, 0}, triangle), 6u);
  EXPECT_EQ(edge_met({-1, 0, 0}, {1, 0, 0}, triangle), 1u) << "along an edge";
  EXPECT_EQ(edge_met({5, 0, 0}, {-1, 0, 0}, triangle), 2u);
  EXPECT_EQ(edge_met({-1, 4, 0}, {1, 0, 0}, triangle), 4u) << "only a corner";
  EXPECT_EQ(edge_met({1, 1, 0}, {1, 0, 0}, triangle), 0u) << "begins inside";
  EXPECT_EQ(edge_met({0, 1, 0}, {1, 0, 0}, triangle), 5u) << "begins on the edge";
  EXPECT_EQ(edge_met({-1, 1, 0}, {1, 0, 0}, triangle, 2), 0u) << "the limit is inside";
  EXPECT_EQ(edge_met({0, 0, 1}, {0, 0, -1}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), 8u) << "no area";
}

TEST(ExactHit, finds_the_corners_that_two_triangles_share) {
  const Triangle a{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const Triangle b{{0, 4, 0}, {4, 4, 1}, {4, 0, 0}};
  EXPECT_EQ(corners_at(a, b, 5u), 6u);
  EXPECT_EQ(corners_at(a, b, 1u), 4u);
  EXPECT_EQ(corners_at(a, b, 3u), 0u) << "one of both is no corner of it";
  EXPECT_EQ(corners_at(a, b, 0u), 0u);
  EXPECT_EQ(corners_at({{-0.0, 0, 0}, {1, 0, 0}, {}}, a, 1u), 1u) << "zeros are one number";
}

TEST(ExactHit, is_certain_of_a_side_only_where_it_is_the_exact_one) {
  SplitMix random(3);
  int certain = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto number = [&] { return static_cast<double>(random.bits() % 9) - 4; };
    const auto point = [&] { return Vec3d{number(), number(), number()}; };
    const Triangle triangle{point(), point(), point()};
    Vec3d direction = point();
    if (i % 2 == 0) direction.x = std::nextafter(direction.x, kInf);
    const int sign = certain_side_sign(direction, triangle);
    certain += sign != 0 ? 1 : 0;
    if (sign != 0) {
      ASSERT_EQ(sign, side_sign(direction, triangle)) << i;
    }
  }
  EXPECT_GT(certain, 10'000);
}

}  // namespace
}  // namespace sightline
