// Pairs of triangles against rational arithmetic, which computes the segments in which both meet
// the line of their planes.

#include "core/geometry/triangle_crossing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "tests/oracle/hull_distance.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

using oracle::ExactPoint;
using Exact3 = std::array<ExactPoint, 3>;

ExactPoint minus(const ExactPoint& a, const ExactPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
ExactPoint cross(const ExactPoint& a, const ExactPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
mpq_class dot(const ExactPoint& a, const ExactPoint& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
ExactPoint normal_of(const Exact3& t) { return cross(minus(t[1], t[0]), minus(t[2], t[0])); }
Exact3 exact(const Triangle& t) {
  return {oracle::exact_point(t.v0), oracle::exact_point(t.v1), oracle::exact_point(t.v2)};
}

/// Where the plane of `other` cuts the inside of `t`, as positions along `direction`.
std::optional<std::pair<mpq_class, mpq_class>> cut(const Exact3& t, const Exact3& other,
                                                   const ExactPoint& direction) {
  const ExactPoint n = normal_of(other);
  std::array<mpq_class, 3> height;
  for (std::size_t i = 0; i < 3; ++i) height[i] = dot(n, minus(t[i], other[0]));
  const auto [least, most] = std::minmax_element(height.begin(), height.end());
  if (*least >= 0 || *most <= 0) return std::nullopt;
  std::optional<std::pair<mpq_class, mpq_class>> found;
  const auto add = [&](const mpq_class& at) {
    if (!found) found.emplace(at, at);
    found->first = std::min(found->first, at);
    found->second = std::max(found->second, at);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (height[i] == 0) add(dot(direction, t[i]));
    if (sgn(height[i]) * sgn(height[j]) < 0) {
      const mpq_class part = height[i] / (height[i] - height[j]);
      add(dot(direction, t[i]) + part * dot(direction, minus(t[j], t[i])));
    }
  }
  return found;
}

bool truly_cross(const Triangle& one, const Triangle& other) {
  const Exact3 a = exact(one), b = exact(other);
  const ExactPoint direction = cross(normal_of(a), normal_of(b));
  if (dot(direction, direction) == 0) return false;
  const auto of_a = cut(a, b, direction), of_b = cut(b, a, direction);
  return of_a && of_b && std::max(of_a->first, of_b->first) < std::min(of_a->second, of_b->second);
}

TEST(TriangleCrossing, is_that_of_rational_arithmetic) {
  constexpr std::uint64_t kSeed = 2401;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::size_t crossing = 0, apart = 0;
  const int cases = test::random_cases(30000);
  for (int round = 0; round < cases; ++round) {
    const int grid = random.integer(1, 4);
    const bool is_grid = random.chance(0.7);
    const double scale = random.chance(0.2) ? std::ldexp(1.0, random.integer(-300, 300)) : 1;
    // Nearly in one plane, so that the float64 volume does not decide.
    const bool is_flat = random.chance(0.3);
    const auto x = [&] {
      return (is_grid ? random.integer(-grid, grid) : random.between(-grid, grid)) * scale;
    };
    const auto point = [&] {
      Vec3d p{x(), x(), x()};
      if (is_flat) p.z = p.x + p.y + random.integer(-1, 1) * 0x1p-50 * scale;
      return p;
    };
    Triangle a{point(), point(), point()}, b{point(), point(), point()};
    if (random.chance(0.2)) b.v0 = a.v1;
    if (random.chance(0.1)) b.v1 = a.v2;
    const auto has_area = [](const Triangle& t) {
      const ExactPoint n = normal_of(exact(t));
      return dot(n, n) != 0;
    };
    if (!has_area(a) || !has_area(b)) continue;
    const bool expected = truly_cross(a, b);
    ASSERT_EQ(triangles_cross(a, b), expected) << "round " << round;
    ASSERT_EQ(triangles_cross(b, a), expected) << "round " << round;
    ASSERT_EQ(triangles_cross({a.v1, a.v0, a.v2}, {b.v2, b.v0, b.v1}), expected) << round;
    ++(expected ? crossing : apart);
  }
  std::printf("%zu pairs cross, %zu do not, wrong 0\n", crossing, apart);
  EXPECT_GT(crossing, test::random_cases(3000u));
  EXPECT_GT(apart, test::random_cases(3000u));
}

TEST(TriangleCrossing, excludes_contacts_of_edges_and_triangles_in_one_plane) {
  const Triangle floor{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  EXPECT_TRUE(triangles_cross(floor, {{1, 1, -1}, {1, 1, 1}, {2, 1, 1}}));
  EXPECT_FALSE(triangles_cross(floor, {{1, 1, 0}, {1, 1, 1}, {2, 1, 1}}));   // stands on it
  EXPECT_FALSE(triangles_cross(floor, {{0, 0, -1}, {0, 0, 1}, {4, 0, 1}}));  // cuts along an edge
  EXPECT_FALSE(triangles_cross(floor, {{1, 1, 0}, {5, 1, 0}, {1, 5, 0}}));   // overlaps in a plane
  EXPECT_FALSE(triangles_cross(floor, floor));
}

}  // namespace
}  // namespace sightline
