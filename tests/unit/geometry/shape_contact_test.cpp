// Depths and contact normals of shapes in triangles against integers and rational arithmetic.

#include "core/geometry/convex/shape_contact.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "core/geometry/triangle_box.h"
#include "tests/oracle/hull_distance.h"
#include "tests/oracle/nearest_point.h"
#include "tests/oracle/random.h"
#include "tests/oracle/whole_hulls.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

using oracle::LeastTranslation;
using oracle::Whole;

constexpr int kBits = 512;

mpf_class root_of(const mpq_class& x) {
  const mpf_class y(x, kBits);
  return sqrt(y);
}
/// Whether x is the float64 nearest to the number, up to 2^-30 of the gap between two.
bool is_rounded(double x, const mpf_class& number) {
  const double below = std::nextafter(x, -INFINITY), above = std::nextafter(x, INFINITY);
  const mpf_class slack(std::ldexp(above - below, -30), kBits);
  return mpf_class(x, kBits) + below <= 2 * number + slack &&
         mpf_class(x, kBits) + above >= 2 * number - slack;
}
bool is_unit(const Vec3d& v, const std::array<mpq_class, 3>& along) {
  const mpq_class square = along[0] * along[0] + along[1] * along[1] + along[2] * along[2];
  const mpf_class length = root_of(square);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!is_rounded(v[static_cast<int>(k)], mpf_class(along[k], kBits) / length)) return false;
  }
  return true;
}
std::array<mpq_class, 3> exact(const Whole& v) {
  return {mpq_class(static_cast<long>(v[0])), mpq_class(static_cast<long>(v[1])),
          mpq_class(static_cast<long>(v[2]))};
}

std::array<Whole, 3> whole_triangle(oracle::Random& random, int size) {
  for (;;) {
    std::array<Whole, 3> t{oracle::whole_point(random, size), oracle::whole_point(random, size),
                           oracle::whole_point(random, size)};
    if (random.chance(0.2)) t[0][2] = t[1][2] = t[2][2] = random.integer(-2, 2);
    if (oracle::cross(oracle::minus(t[1], t[0]), oracle::minus(t[2], t[0])) != Whole{}) return t;
  }
}
Triangle scaled(const std::array<Whole, 3>& t, int exponent) {
  return {oracle::scaled(t[0], exponent), oracle::scaled(t[1], exponent),
          oracle::scaled(t[2], exponent)};
}
int random_exponent(oracle::Random& random) {
  constexpr std::array<int, 8> kExponents{0, 0, 0, 0, 300, -300, 1000, -1074};
  return kExponents[random.index(kExponents.size())];
}

/// How often each kind was judged.
struct Tally {
  std::size_t deep = 0, touch = 0;
};

/// Judges the contact of the hull of whole points, over `divisor`, times 2^exponent.
std::string fault_of(const ShapeContact& contact, const std::vector<Whole>& points,
                     const std::array<Whole, 3>& triangle, long long divisor, int exponent,
                     Tally& tally) {
  const LeastTranslation truth = oracle::least_translation(points, triangle);
  const mpq_class overlap(static_cast<long>(truth.overlap));
  const mpq_class square(static_cast<long>(oracle::dot(truth.along, truth.along)));
  mpq_class depth = overlap * overlap / square /
                    (mpq_class(static_cast<long>(divisor)) * static_cast<long>(divisor));
  mpf_class length = root_of(depth);
  if (exponent >= 0) {
    mpf_mul_2exp(length.get_mpf_t(), length.get_mpf_t(), static_cast<unsigned>(exponent));
  } else {
    mpf_div_2exp(length.get_mpf_t(), length.get_mpf_t(), static_cast<unsigned>(-exponent));
  }
  if (!is_rounded(contact.depth, length)) return "depth " + std::to_string(contact.depth);
  if (truth.overlap > 0 || is_unit(contact.normal, exact(truth.along))) {
    ++(truth.overlap > 0 ? tally.deep : tally.touch);
    return is_unit(contact.normal, exact(truth.along)) ? "" : "normal";
  }
  // The shape touches, along a cross product that is not of edges only.
  ++tally.touch;
  const Whole normal = oracle::cross(oracle::minus(triangle[1], triangle[0]),
                                     oracle::minus(triangle[2], triangle[0]));
  if (truth.along == normal || truth.along == oracle::minus({}, normal)) return "normal";
  double most = -INFINITY, least = INFINITY;
  for (const Whole& p : triangle) {
    const Vec3d v = oracle::scaled(p, 0);
    most =
        std::fmax(most, v.x * contact.normal.x + v.y * contact.normal.y + v.z * contact.normal.z);
  }
  for (const Whole& p : points) {
    const Vec3d v = oracle::scaled(p, 0);
    least =
        std::fmin(least, v.x * contact.normal.x + v.y * contact.normal.y + v.z * contact.normal.z);
  }
  return most - least < 0x1p-30 ? "" : "normal of a touching shape";
}

TEST(ShapeContact, of_hulls_and_boxes_is_as_deep_as_integers_say) {
  constexpr std::uint64_t kSeed = 2421;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::array<Tally, 3> tally;
  // Few turned boxes touch: a sanitized build needs enough rounds to meet some.
  const int cases = std::max(test::random_cases(1500), 400);
  for (int round = 0; round < cases;) {
    const int size = random.integer(1, 7), exponent = random_exponent(random);
    const auto triangle = whole_triangle(random, size);
    const Triangle t = scaled(triangle, exponent);
    const std::string what = "round " + std::to_string(round);
    const int form = random.integer(0, 2);
    if (form == 0) {
      std::vector<Whole> points;
      for (std::size_t k = random.index(7) + 1; k > 0; --k)
        points.push_back(oracle::whole_point(random, size));
      if (random.chance(0.2)) {
        for (Whole& p : points) p[2] = triangle[0][2];
      }
      std::vector<Vec3d> floats;
      floats.reserve(points.size());
      for (const Whole& p : points) floats.push_back(oracle::scaled(p, exponent));
      const ConvexHull hull(PointHull{floats});
      if (!triangle_meets_box(t, hull)) continue;
      const auto contact = contact_of(hull.parts(), t, Deadline::never());
      ASSERT_TRUE(contact);
      ASSERT_EQ(fault_of(*contact, points, triangle, 1, exponent, tally[0]), "") << what;
    } else if (form == 1) {
      Whole low = oracle::whole_point(random, size), high = oracle::whole_point(random, size);
      for (std::size_t k = 0; k < 3; ++k) {
        if (low[k] > high[k]) std::swap(low[k], high[k]);
      }
      const Box3d box{oracle::scaled(low, exponent), oracle::scaled(high, exponent)};
      if (!triangle_meets_box(t, box)) continue;
      std::vector<Whole> corners;
      for (std::size_t c = 0; c < 8; ++c) {
        Whole p = low;
        for (std::size_t k = 0; k < 3; ++k) {
          if ((c >> k & 1u) != 0) p[k] = high[k];
        }
        corners.push_back(p);
      }
      ASSERT_EQ(fault_of(contact_of(box, t), corners, triangle, 1, exponent, tally[1]), "") << what;
    } else {
      std::array<Whole, 3> axes;
      for (Whole& axis : axes) axis = oracle::whole_point(random, 2);
      long long determinant = oracle::dot(axes[0], oracle::cross(axes[1], axes[2]));
      if (determinant == 0) continue;
      const Whole center = oracle::whole_point(random, size);
      const Whole half{random.integer(0, 12), random.integer(0, 12), random.integer(0, 12)};
      OrientedBox box{oracle::scaled(center, exponent), oracle::scaled(half, exponent), {}};
      for (std::size_t k = 0; k < 3; ++k) box.axes[k] = oracle::scaled(axes[k], 0);
      if (!triangle_meets_box(t, box)) continue;
      // Everything times the determinant is whole.
      std::vector<Whole> corners;
      for (std::size_t c = 0; c < 8; ++c) {
        Whole p{};
        for (std::size_t k = 0; k < 3; ++k) p[k] = center[k] * determinant;
        for (std::size_t i = 0; i < 3; ++i) {
          const Whole edge = oracle::cross(axes[(i + 1) % 3], axes[(i + 2) % 3]);
          for (std::size_t k = 0; k < 3; ++k)
            p[k] += ((c >> i & 1u) != 0 ? 1 : -1) * half[i] * edge[k];
        }
        corners.push_back(p);
      }
      std::array<Whole, 3> larger = triangle;
      if (determinant < 0) {
        for (Whole& p : corners) p = {-p[0], -p[1], -p[2]};
        determinant = -determinant;
      }
      for (Whole& p : larger) p = {p[0] * determinant, p[1] * determinant, p[2] * determinant};
      ASSERT_EQ(fault_of(contact_of(box, t), corners, larger, determinant, exponent, tally[2]), "")
          << what;
    }
    ++round;
  }
  std::printf(
      "%d contacts: deep %zu, %zu and %zu of hulls, boxes and turned boxes, touching %zu, %zu and "
      "%zu; wrong 0\n",
      cases, tally[0].deep, tally[1].deep, tally[2].deep, tally[0].touch, tally[1].touch,
      tally[2].touch);
  for (const Tally& kind : tally) {
    EXPECT_GT(kind.deep, test::random_cases(50u));
    EXPECT_GT(kind.touch, test::random_cases(20u));
  }
}

TEST(ShapeContact, of_balls_and_capsules_is_as_deep_as_rational_arithmetic_says) {
  constexpr std::uint64_t kSeed = 2422;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::size_t beside = 0, through = 0;
  const int cases = test::random_cases(500);
  for (int round = 0; round < cases;) {
    const int size = random.integer(1, 7), exponent = random.chance(0.5) ? 0 : 200;
    const auto triangle = whole_triangle(random, size);
    const Triangle t = scaled(triangle, exponent);
    const Whole from = oracle::whole_point(random, size),
                to = random.chance(0.3) ? from : oracle::whole_point(random, size);
    const int radius = random.integer(0, 9);
    const Capsule capsule{oracle::scaled(from, exponent), oracle::scaled(to, exponent),
                          std::ldexp(radius, exponent)};
    if (!triangle_meets_box(t, capsule)) continue;
    const ShapeContact contact = contact_of(capsule, t);
    const std::vector<oracle::ExactPoint> axis{exact(from), exact(to)},
        corners{exact(triangle[0]), exact(triangle[1]), exact(triangle[2])};
    oracle::ExactPoint away;
    const mpq_class square = oracle::hull_square_distance(axis, corners, &away);
    const double depth = std::ldexp(contact.depth, -exponent);
    const std::string what = "round " + std::to_string(round) + " depth " + std::to_string(depth);
    if (square > 0) {
      ASSERT_TRUE(is_rounded(depth, radius - root_of(square))) << what;
      ASSERT_TRUE(is_unit(contact.normal, away)) << what;
      ++beside;
    } else {
      const std::vector<Whole> ends{from, to};
      const LeastTranslation truth = oracle::least_translation(ends, triangle);
      const mpq_class inner(static_cast<long>(truth.overlap * truth.overlap),
                            static_cast<long>(oracle::dot(truth.along, truth.along)));
      ASSERT_TRUE(is_rounded(depth, radius + root_of(inner))) << what;
      if (truth.overlap > 0) {
        ASSERT_TRUE(is_unit(contact.normal, exact(truth.along))) << what;
      }
      ++through;
    }
    ++round;
  }
  std::printf("%d contacts: %zu beside the axis, %zu on it; wrong 0\n", cases, beside, through);
  EXPECT_GT(beside, test::random_cases(100u));
  EXPECT_GT(through, test::random_cases(50u));
}

TEST(ShapeContact, of_open_boxes_is_that_of_their_sides) {
  const Triangle t{{0, 0, 1}, {4, 0, 1}, {0, 4, 1}};
  // Above z = -1 there is no end; the triangle is at z = 1: down by 2.
  const double open = std::numeric_limits<double>::infinity();
  const ShapeContact below = contact_of(Box3d{{-open, -open, -open}, {open, open, 3}}, t);
  EXPECT_EQ(below.depth, 2);
  EXPECT_EQ(below.normal, (Vec3d{0, 0, -1}));
  const ShapeContact everywhere = contact_of(Box3d{{-open, -open, -open}, {open, open, open}}, t);
  EXPECT_EQ(everywhere.depth, open);
  const ShapeContact turned =
      contact_of(OrientedBox{{0, 0, 0}, {open, open, 3}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 2}}}}, t);
  EXPECT_EQ(turned.depth, 0.5) << "the sides are at z = -1.5 and z = 1.5";
  EXPECT_EQ(turned.normal, (Vec3d{0, 0, -1}));
}

TEST(ShapeContact, prefers_the_front_of_the_triangle) {
  const Triangle t{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, back{t.v0, t.v2, t.v1};
  for (const auto& [triangle, z] : {std::pair{t, 1.0}, std::pair{back, -1.0}}) {
    EXPECT_EQ(contact_of(Sphere{{0, 0, 0}, 2}, triangle).normal, (Vec3d{0, 0, z}));
    EXPECT_EQ(contact_of(Sphere{{0, 0, 0}, 2}, triangle).depth, 2);
    EXPECT_EQ(contact_of(Box3d{{-1, -1, -1}, {1, 1, 1}}, triangle).normal, (Vec3d{0, 0, z}));
  }
  // At equal depth the side of the box with the larger x comes first, then the larger y.
  const Triangle small{{1, -1, 0}, {0, 1, -1}, {-1, 0, 1}};
  EXPECT_EQ(contact_of(Box3d{{-8, -8, -8}, {8, 8, 8}}, small).depth, 9);
  EXPECT_EQ(contact_of(Box3d{{-8, -8, -8}, {8, 8, 8}}, small).normal, (Vec3d{1, 0, 0}));
  EXPECT_EQ(contact_of(Box3d{{-9, -8, -8}, {9, 8, 8}}, small).normal, (Vec3d{0, 1, 0}));
  EXPECT_EQ(contact_of(Box3d{{-9, -9, -9}, {9, 9, 8}}, small).normal, (Vec3d{0, 0, -1}));
}

}  // namespace
}  // namespace sightline
