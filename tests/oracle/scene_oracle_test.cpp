#include "tests/oracle/scene_oracle.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>

#include "core/base/infinity.h"
#include "tests/oracle/brute_force.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline::oracle {
namespace {

using MakeNumber = std::function<double(Random&)>;

Vec3d point(Random& random, const MakeNumber& number) {
  const double x = number(random), y = number(random);
  return {x, y, number(random)};
}

Vec3d blend(const Triangle& w, double a, double b) {
  Vec3d p;
  for (int k = 0; k < 3; ++k) p[k] = w.v0[k] + a * (w.v1[k] - w.v0[k]) + b * (w.v2[k] - w.v0[k]);
  return p;
}

/// A ray that aims at a corner, an edge point, an inner point, a neighbour of one, or at nothing.
Ray make_ray(Random& random, const MakeNumber& number, const std::vector<Triangle>& triangles) {
  const Triangle& target = triangles[random.index(triangles.size())];
  Ray ray;
  ray.origin = random.chance(0.2) ? blend(target, 0.5, 0.25) : point(random, number);
  Vec3d aim = point(random, number);
  switch (random.index(6)) {
    case 0:
      aim = target.v1;
      break;
    case 1:
      aim = blend(target, 0.5, 0);
      break;
    case 2:
      aim = blend(target, 0.25, 0.5);
      break;
    case 3:  // in the plane
      ray.origin = blend(target, random.integer(-2, 2), random.integer(-2, 2));
      aim = blend(target, random.integer(-2, 2), random.integer(-2, 2));
      break;
    default:
      break;
  }
  for (int k = 0; k < 3; ++k) ray.direction[k] = aim[k] - ray.origin[k];
  if (random.chance(0.1)) ray.direction[random.integer(0, 2)] = random.chance(0.5) ? 0.0 : -0.0;
  bool usable = false;
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(ray.direction[k])) ray.direction[k] = number(random);
    if (!std::isfinite(ray.origin[k])) ray.origin[k] = number(random);
    usable = usable || ray.direction[k] != 0;
  }
  if (!usable) ray.direction.x = 1;
  switch (random.index(5)) {
    case 0:
      ray.tmin = -kInf;
      break;
    case 1:
      ray.tmin = random.integer(-2, 1);
      ray.tmax = ray.tmin + random.integer(0, 2);
      break;
    case 2:
      ray.tmin = random.any_double();
      ray.tmax = random.any_double();
      if (ray.tmin > ray.tmax) std::swap(ray.tmin, ray.tmax);
      break;
    default:
      break;
  }
  return ray;
}

/// Scenes of a few triangles with shared corners, duplicates, triangles without area and
/// non-finite ones; every mode of the oracle against the brute force in mpq_class.
void compare_with_brute_force(std::uint64_t seed, int scenes, int all_rays,
                              const MakeNumber& number) {
  const int rays = test::random_cases(all_rays);
  Random random(seed);
  std::size_t hits_seen = 0;
  for (int s = 0; s < scenes; ++s) {
    std::vector<Vec3d> corners;
    corners.reserve(9);
    for (int i = 0; i < 9; ++i) corners.push_back(point(random, number));
    std::vector<Triangle> triangles;
    triangles.reserve(28);
    for (int i = 0; i < 24; ++i) {
      triangles.push_back({corners[random.index(corners.size())],
                           corners[random.index(corners.size())],
                           corners[random.index(corners.size())]});
    }
    triangles.push_back(triangles[3]);
    triangles.push_back({triangles[5].v1, triangles[5].v2, triangles[5].v0});
    const SceneOracle oracle(triangles);
    triangles.push_back({{kInf, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    triangles.push_back({{0, 0, 0}, {0, std::nan(""), 0}, {0, 0, 1}});
    const SceneOracle with_bad(triangles);
    ASSERT_EQ(with_bad.dropped_not_finite(), 2u);
    ASSERT_EQ(with_bad.dropped_no_area(), oracle.dropped_no_area());

    for (int r = 0; r < rays; ++r) {
      const Ray ray = make_ray(random, number, {triangles.begin(), triangles.end() - 2});
      const std::vector<BruteHit> truth = brute_all(ray, triangles);
      hits_seen += truth.size();
      SCOPED_TRACE(testing::Message() << "seed " << seed << " scene " << s << " ray " << r);

      const auto all = with_bad.all(ray);
      ASSERT_EQ(all.size(), truth.size());
      for (std::size_t i = 0; i < truth.size(); ++i) {
        ASSERT_EQ(all[i].triangle, truth[i].triangle);
        ASSERT_EQ(to_mpq(all[i].t), truth[i].t);
      }
      ASSERT_EQ(with_bad.count(ray), truth.size());
      ASSERT_EQ(oracle.any(ray), !truth.empty());
      const auto closest = oracle.closest(ray);
      ASSERT_EQ(closest.has_value(), !truth.empty());
      if (closest) {
        ASSERT_EQ(closest->triangle, truth[0].triangle);
        ASSERT_EQ(to_mpq(closest->t), truth[0].t);
        ASSERT_EQ(closest->t_rounded, round_to_double(closest->t));
      }
    }
  }
  // The comparison is worth something only if rays hit.
  EXPECT_GT(hits_seen, static_cast<std::size_t>(scenes * rays / 20));
}

TEST(SceneOracle, agrees_with_brute_force_on_a_small_grid) {
  compare_with_brute_force(11, 40, 100, [](Random& r) { return r.integer(-2, 2); });
}

TEST(SceneOracle, agrees_with_brute_force_on_ordinary_numbers) {
  compare_with_brute_force(12, 25, 80, [](Random& r) { return r.between(-1, 1); });
}

TEST(SceneOracle, agrees_with_brute_force_at_the_ends_of_the_range) {
  for (const double scale : {0x1p-1074, 0x1p-1022, 1e-40, 1e-30, 1e30, 1e300, 0x1p1022}) {
    compare_with_brute_force(13, 8, 60,
                             [scale](Random& r) { return scale * r.integer(-2, 2) * 0.875; });
  }
}

TEST(SceneOracle, agrees_with_brute_force_on_mixed_magnitudes) {
  compare_with_brute_force(14, 12, 80, [](Random& r) {
    return std::ldexp(r.integer(-4, 4), r.chance(0.7) ? 0 : r.integer(-1000, 1000));
  });
}

TEST(SceneOracle, agrees_with_brute_force_far_from_zero) {
  compare_with_brute_force(15, 30, 100, [](Random& r) { return 1e8 + r.integer(-8, 8) * 0x1p-26; });
}

TEST(SceneOracle, agrees_with_brute_force_on_random_bit_patterns) {
  // Sixteen numbers of any exponent, used again and again so that rays do hit.
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Random pool_random(seed);
    std::vector<double> pool;
    pool.reserve(6);
    for (int i = 0; i < 6; ++i) pool.push_back(pool_random.any_double());
    compare_with_brute_force(100 + seed, 1, 60,
                             [pool](Random& r) { return pool[r.index(pool.size())]; });
  }
}

TEST(SceneOracle, skips_nothing_in_a_tree_of_many_nodes) {
  // A closed bumpy ball: aims at its corners and edges, judged without tree and filter.
  Random random(16);
  std::vector<Vec3d> corners;
  std::vector<Triangle> triangles;
  constexpr int kRows = 12, kColumns = 24;
  for (int i = 0; i <= kRows; ++i) {
    for (int j = 0; j < kColumns; ++j) {
      const double a = 3.14159265 * i / kRows, b = 6.2831853 * j / kColumns;
      const double r = random.between(0.9, 1.1);
      corners.push_back(
          {r * std::sin(a) * std::cos(b), r * std::sin(a) * std::sin(b), std::cos(a)});
    }
  }
  const auto at = [&](int i, int j) {
    return corners[static_cast<std::size_t>(i) * kColumns + static_cast<std::size_t>(j) % kColumns];
  };
  for (int i = 0; i < kRows; ++i) {
    for (int j = 0; j < kColumns; ++j) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  const SceneOracle oracle(triangles);
  for (int r = 0; r < test::random_cases(1000); ++r) {
    const Ray ray = make_ray(
        random, [](Random& q) { return q.between(-2, 2); }, triangles);
    std::vector<OracleHit> truth;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (const auto t = least_t(ray, triangles[i])) truth.push_back({i, *t, round_to_double(*t)});
    }
    const auto all = oracle.all(ray);
    const auto closest = oracle.closest(ray);
    ASSERT_EQ(all.size(), truth.size()) << r;
    ASSERT_EQ(oracle.any(ray), !truth.empty()) << r;
    ASSERT_EQ(closest.has_value(), !truth.empty()) << r;
    for (const OracleHit& hit : truth) {
      const int order = compare(closest->t, hit.t);
      ASSERT_LE(order, 0) << r;
      if (order == 0) {
        ASSERT_LE(closest->triangle, hit.triangle) << r;
      }
    }
  }
}

TEST(SceneOracle, answers_nothing_for_an_empty_scene) {
  const SceneOracle oracle({});
  EXPECT_FALSE(oracle.closest({{0, 0, 0}, {1, 0, 0}}).has_value());
  EXPECT_FALSE(oracle.any({{0, 0, 0}, {1, 0, 0}}));
  EXPECT_EQ(oracle.count({{0, 0, 0}, {1, 0, 0}}), 0u);
}

TEST(Conservative, the_overlap_with_a_box_encloses_the_exact_one) {
  // One axis at a time: the other two are unbounded as far as the ray goes.
  Random random(6);
  constexpr double kMax = std::numeric_limits<double>::max();
  for (int i = 0; i < test::random_cases(300000); ++i) {
    const auto number = [&] {
      return random.chance(0.5)   ? random.between(-1, 1)
             : random.chance(0.5) ? static_cast<double>(random.integer(-9, 9)) * 0x1p-1074
                                  : random.any_double();
    };
    double low = number(), high = number();
    if (low > high) std::swap(low, high);
    const double origin = number(), direction = number();
    if (direction == 0) continue;
    const Overlap found = overlap({{origin, 0, 0}, {direction, 0, 0}, -kInf},
                                  {{low, -kMax, -kMax}, {high, kMax, kMax}}, kInf);
    mpq_class from = (mpq_class(low) - mpq_class(origin)) / mpq_class(direction);
    mpq_class to = (mpq_class(high) - mpq_class(origin)) / mpq_class(direction);
    if (direction < 0) std::swap(from, to);
    ASSERT_TRUE(std::isinf(found.low) ? found.low < 0 : mpq_class(found.low) <= from) << i;
    ASSERT_TRUE(std::isinf(found.high) ? found.high > 0 : mpq_class(found.high) >= to) << i;
  }
}

TEST(Conservative, neighbours_are_those_of_nextafter) {
  Random random(5);
  for (int i = 0; i < 100000; ++i) {
    const double value = random.any_double();
    ASSERT_EQ(next_up(value), std::nextafter(value, kInf));
    ASSERT_EQ(next_down(value), std::nextafter(value, -kInf));
  }
  EXPECT_EQ(next_up(0.0), std::nextafter(0.0, kInf));
  EXPECT_EQ(next_down(-0.0), std::nextafter(0.0, -kInf));
  EXPECT_EQ(next_up(kInf), kInf);
  EXPECT_EQ(next_down(kInf), std::numeric_limits<double>::max());
}

}  // namespace
}  // namespace sightline::oracle
