// Distances of points from triangles against rational arithmetic: the interval holds the distance,
// the exact stages round it once.

#include "core/geometry/point_triangle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/oracle/nearest_point.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

using oracle::Random;

struct Sample {
  Vec3d point;
  Triangle triangle;
};

/// Grids, where many feet lie on corners and edges and many distances are equal; ordinary numbers;
/// slivers; and any magnitude at all.
Sample sample(Random& random, int kind) {
  const double scale = kind == 3 ? std::ldexp(1.0, random.integer(-300, 300)) : 1;
  const auto x = [&] {
    if (kind == 0) return static_cast<double>(random.integer(-4, 4));
    if (kind == 4) return random.any_double();
    return random.between(-4, 4) * scale;
  };
  Sample s{{x(), x(), x()}, {{x(), x(), x()}, {x(), x(), x()}, {x(), x(), x()}}};
  if (kind == 2) {  // a sliver, and the point often on it
    const auto between = [&](int k) {
      return s.triangle.v0[k] + random.unit() * (s.triangle.v1[k] - s.triangle.v0[k]);
    };
    s.triangle.v2 = {between(0), between(1), between(2) + random.unit() * 1e-9};
    if (random.chance(0.5)) s.point = {between(0), between(1), between(2)};
  }
  return s;
}

mpq_class root_bounds(double distance) { return mpq_class(distance) * mpq_class(distance); }

TEST(PointTriangle, is_what_rational_arithmetic_says) {
  constexpr std::uint64_t kSeed = 81;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  Random random(kSeed);
  std::size_t on_edge = 0, inside = 0, certain = 0;
  for (int round = 0; round < test::random_cases(20000); ++round) {
    const Sample s = sample(random, round % 16 == 15 ? 4 : round % 4);
    const oracle::Triangle same{s.triangle.v0, s.triangle.v1, s.triangle.v2};
    if (oracle::has_no_area(same)) continue;
    const oracle::NearestPoint truth = oracle::nearest(s.point, same);

    const DistanceRange range = distance_range(s.point, s.triangle);
    ASSERT_LE(root_bounds(range.low), truth.square) << round;
    if (std::isfinite(range.high)) {
      ASSERT_GE(root_bounds(range.high), truth.square) << round;
    }
    const ExactDistance exact = exact_distance(s.point, s.triangle);
    ASSERT_TRUE(oracle::is_rounded_root(exact.rounded(), truth.square)) << round;
    if (std::isfinite(exact.rounded())) {
      const int order = cmp(truth.square, root_bounds(exact.rounded()));
      ASSERT_EQ(compare(exact, exact.rounded()), order < 0 ? -1 : order > 0 ? 1 : 0);
    }
    const NearestDetail near = nearest_detail(s.point, s.triangle);
    ASSERT_EQ(near.on_edge, truth.on_edge) << round;
    ASSERT_EQ(near.detail.front, truth.front) << round;
    for (std::size_t k = 0; k < 3; ++k) {
      const oracle::Rational position{truth.position[k].get_num(), truth.position[k].get_den(), 0};
      ASSERT_EQ(near.detail.position[static_cast<int>(k)], oracle::round_to_double(position));
    }
    ASSERT_EQ(near.detail.u, oracle::round_to_double({truth.u.get_num(), truth.u.get_den(), 0}));
    ASSERT_EQ(near.detail.v, oracle::round_to_double({truth.v.get_num(), truth.v.get_den(), 0}));
    (truth.on_edge ? on_edge : inside) += 1;

    const CornerSet corners = certain_nearest_edge(s.point, s.triangle);
    if (corners == 0) continue;
    ++certain;
    const std::array<mpq_class, 3> weight{1 - truth.u - truth.v, truth.u, truth.v};
    for (std::size_t i = 0; i < 3; ++i)
      ASSERT_EQ(weight[i] != 0, (corners >> i & 1u) != 0) << round;
  }
  std::printf("on edges %zu, of these certain by float64 %zu, inside %zu\n", on_edge, certain,
              inside);
  EXPECT_GT(inside, test::random_cases(1000u));
  EXPECT_GT(certain, on_edge / 4);
}

TEST(PointTriangle, are_compared_exactly) {
  constexpr std::uint64_t kSeed = 82;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  Random random(kSeed);
  std::size_t equal = 0;
  for (int round = 0; round < test::random_cases(10000); ++round) {
    const int kind = round % 16 == 15 ? 4 : round % 4;
    const Sample one = sample(random, kind);
    Sample other = sample(random, kind);
    if (round % 3 == 0) {  // a common edge, at nearly or exactly the same distance
      other.triangle.v0 = one.triangle.v1;
      other.triangle.v1 = one.triangle.v0;
    }
    const oracle::Triangle a{one.triangle.v0, one.triangle.v1, one.triangle.v2};
    const oracle::Triangle b{other.triangle.v0, other.triangle.v1, other.triangle.v2};
    if (oracle::has_no_area(a) || oracle::has_no_area(b)) continue;
    const int order =
        cmp(oracle::nearest(one.point, a).square, oracle::nearest(one.point, b).square);
    ASSERT_EQ(
        compare(exact_distance(one.point, one.triangle), exact_distance(one.point, other.triangle)),
        order < 0   ? -1
        : order > 0 ? 1
                    : 0)
        << round;
    equal += order == 0 ? 1u : 0u;
  }
  EXPECT_GT(equal, test::random_cases(500u));
}

TEST(PointTriangle, holds_the_largest_numbers_there_are) {
  // Ten differences of float64 numbers at both ends of their range, multiplied: what Dyadic has
  // room for.
  const double most = 0x1.fffffffffffffp1023, least = 5e-324;
  const Triangle wide{{-most, least, -most}, {most, -most, 3 * least}, {least, most, most}};
  const Triangle other{{-most, -most, least}, {most, least, -most}, {5 * least, most, most}};
  const Vec3d point{most, most, -most};
  for (const Triangle& t : {wide, other}) {
    const oracle::Triangle same{t.v0, t.v1, t.v2};
    EXPECT_TRUE(oracle::is_rounded_root(exact_distance(point, t).rounded(),
                                        oracle::nearest(point, same).square));
  }
  const int order = cmp(oracle::nearest(point, {wide.v0, wide.v1, wide.v2}).square,
                        oracle::nearest(point, {other.v0, other.v1, other.v2}).square);
  EXPECT_EQ(compare(exact_distance(point, wide), exact_distance(point, other)), order < 0   ? -1
                                                                                : order > 0 ? 1
                                                                                            : 0);
}

}  // namespace
}  // namespace sightline
