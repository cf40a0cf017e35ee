// Capsules and convex regions, distances of segments and triangles, and what lies within a shape,
// against rational arithmetic.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/geometry/exact_hit.h"
#include "core/geometry/triangle_distance.h"
#include "core/geometry/triangle_within.h"
#include "tests/oracle/hull_distance.h"
#include "tests/oracle/nearest_point.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

using oracle::ExactPoint;

/// Numbers of one round: often on a grid, where much touches exactly, sometimes of another scale.
class Numbers {
 public:
  explicit Numbers(oracle::Random& random)
      : random_(random),
        is_grid_(random.chance(0.7)),
        scale_(std::ldexp(1.0, random.chance(0.3) ? random.integer(-300, 300) : 0)) {}

  double number(int low, int high) {
    return (is_grid_ ? random_.integer(low, high) : random_.between(low, high)) * scale_;
  }
  double scale() const { return scale_; }
  Vec3d point() {
    const double x = number(-6, 6), y = number(-6, 6);
    return {x, y, number(-6, 6)};
  }
  Triangle triangle() {
    const Vec3d a = point(), b = point();
    return {a, b, point()};
  }

 private:
  oracle::Random& random_;
  bool is_grid_;
  double scale_;
};

oracle::Triangle for_oracle(const Triangle& t) { return {t.v0, t.v1, t.v2}; }
std::vector<ExactPoint> exact_corners(const Triangle& t) {
  return {oracle::exact_point(t.v0), oracle::exact_point(t.v1), oracle::exact_point(t.v2)};
}

TEST(Regions, capsules_meet_what_rational_arithmetic_says) {
  constexpr std::uint64_t kSeed = 166;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::size_t meet = 0, touch = 0, within = 0;
  for (int round = 0; round < test::random_cases(8000); ++round) {
    Numbers numbers(random);
    Triangle t = numbers.triangle();
    Capsule capsule{numbers.point(), numbers.point(), std::fabs(numbers.number(0, 7))};
    if (random.chance(0.1)) capsule.to = capsule.from;
    if (random.chance(0.3)) {  // flat, the axis level above it
      t.v0.z = t.v1.z = t.v2.z = 0;
      capsule.to.z = capsule.from.z;
      capsule.radius = std::fabs(capsule.from.z);
    }
    const std::vector<ExactPoint> axis{oracle::exact_point(capsule.from),
                                       oracle::exact_point(capsule.to)};
    const mpq_class square = mpq_class(capsule.radius) * mpq_class(capsule.radius);
    bool expected = false;
    if (!oracle::has_no_area(for_oracle(t))) {
      const mpq_class distance = oracle::hull_square_distance(axis, exact_corners(t));
      expected = distance <= square;
      touch += distance == square ? 1u : 0u;
    }
    ASSERT_EQ(triangle_meets_box(t, capsule), expected) << "round " << round;
    bool inside = true;
    for (const ExactPoint& corner : exact_corners(t))
      inside = inside && oracle::hull_square_distance(axis, {corner}) <= square;
    ASSERT_EQ(corners_within(t, capsule), inside) << "round " << round;
    const Sphere sphere{capsule.from, capsule.radius};
    bool in_sphere = true;
    for (const ExactPoint& corner : exact_corners(t))
      in_sphere = in_sphere && oracle::hull_square_distance({axis[0]}, {corner}) <= square;
    ASSERT_EQ(corners_within(t, sphere), in_sphere) << "round " << round;
    meet += expected ? 1u : 0u;
    within += inside ? 1u : 0u;
  }
  std::printf("8000 capsules: meet %zu, touch exactly %zu, hold %zu, wrong 0\n", meet, touch,
              within);
  EXPECT_GT(meet, test::random_cases(1000u));
  EXPECT_GT(touch, test::random_cases(100u));
  EXPECT_GT(within, test::random_cases(100u));
}

TEST(Regions, convex_ones_meet_what_rational_arithmetic_says) {
  constexpr std::uint64_t kSeed = 167;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::size_t meet = 0, open = 0, within = 0;
  for (int round = 0; round < test::random_cases(12000); ++round) {
    Numbers numbers(random);
    const Triangle t = numbers.triangle();
    std::vector<HalfSpace> planes;
    const std::size_t count = random.index(9) + 1;
    for (std::size_t i = 0; i < count; ++i) {
      HalfSpace plane{{double(random.integer(-2, 2)), double(random.integer(-2, 2)),
                       double(random.integer(-2, 2))},
                      0};
      if (random.chance(0.2)) plane.normal = random.direction();
      if (plane.normal == Vec3d{}) plane.normal.x = 1;
      // Through a point near the triangle, or through one of its own, often exactly.
      const Vec3d p = random.chance(0.3) ? t.v1 : numbers.point();
      plane.offset = plane.normal.x * p.x + plane.normal.y * p.y + plane.normal.z * p.z;
      planes.push_back(plane);
      if (random.chance(0.1)) {  // nothing between them but the plane
        planes.push_back({{-plane.normal.x, -plane.normal.y, -plane.normal.z}, -plane.offset});
      }
    }
    std::vector<oracle::ExactHalfSpace> exact;
    exact.reserve(planes.size());
    for (const HalfSpace& plane : planes)
      exact.push_back({oracle::exact_point(plane.normal), mpq_class(plane.offset)});
    const bool has_area = !oracle::has_no_area(for_oracle(t));
    const bool expected = has_area && oracle::meets_all(for_oracle(t), exact);
    const ConvexRegion region{planes};
    ASSERT_EQ(triangle_meets_box(t, region), expected) << "round " << round;
    bool inside = true;
    bool corner_in = false;
    for (const Vec3d& p : {t.v0, t.v1, t.v2}) {
      bool in = true;
      const ExactPoint q = oracle::exact_point(p);
      for (const oracle::ExactHalfSpace& h : exact)
        in = in && h.normal[0] * q[0] + h.normal[1] * q[1] + h.normal[2] * q[2] <= h.offset;
      inside = inside && in;
      corner_in = corner_in || in;
    }
    ASSERT_EQ(corners_within(t, region), inside) << "round " << round;
    meet += expected ? 1u : 0u;
    open += expected && !corner_in ? 1u : 0u;
    within += inside && has_area ? 1u : 0u;
  }
  std::printf("12000 regions: meet %zu, of them without a corner inside %zu, hold %zu, wrong 0\n",
              meet, open, within);
  EXPECT_GT(meet, test::random_cases(1000u));
  EXPECT_GT(open, test::random_cases(300u));
  EXPECT_GT(within, test::random_cases(100u));
}

TEST(Regions, oriented_boxes_hold_what_rational_arithmetic_says) {
  oracle::Random random(168);
  std::size_t within = 0;
  for (int round = 0; round < test::random_cases(20000); ++round) {
    Numbers numbers(random);
    const OrientedBox box{numbers.point(),
                          {std::fabs(numbers.number(0, 20)), std::fabs(numbers.number(0, 20)),
                           std::fabs(numbers.number(0, 20))},
                          {{{1, 1, 0}, {1, -1, 0}, {0, 0, 1}}}};
    const Vec3d p = numbers.point();
    bool expected = true;
    for (int k = 0; k < 3; ++k) {
      mpq_class sum = 0;
      for (int i = 0; i < 3; ++i)
        sum += mpq_class(box.axes[static_cast<std::size_t>(k)][i]) *
               (mpq_class(p[i]) - mpq_class(box.center[i]));
      expected = expected && abs(sum) <= mpq_class(box.half[k]);
    }
    ASSERT_EQ(is_within(p, box), expected) << "round " << round;
    within += expected ? 1u : 0u;
  }
  EXPECT_GT(within, test::random_cases(3000u));
}

TEST(Regions, triangles_are_as_far_as_rational_arithmetic_says) {
  constexpr std::uint64_t kSeed = 169;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::size_t meet = 0, pairs = 0;
  double widest = 0;
  for (int round = 0; round < test::random_cases(3000); ++round) {
    Numbers numbers(random);
    Triangle a = numbers.triangle(), b = numbers.triangle();
    if (random.chance(0.2)) b.v1 = a.v2;
    if (random.chance(0.2)) a.v0.z = a.v1.z = a.v2.z = b.v0.z = b.v1.z = b.v2.z = 0;
    if (oracle::has_no_area(for_oracle(a)) || oracle::has_no_area(for_oracle(b))) continue;
    const mpq_class square = oracle::hull_square_distance(exact_corners(a), exact_corners(b));
    const ExactDistance distance = exact_distance(corners_of(a), b);
    ASSERT_TRUE(oracle::is_rounded_root(distance.rounded(), square)) << "round " << round;
    const DistanceRange range = distance_range(corners_of(a), corners_of(b));
    ASSERT_LE(mpq_class(range.low) * mpq_class(range.low), square) << "round " << round;
    ASSERT_GE(mpq_class(range.high) * mpq_class(range.high), square) << "round " << round;
    if (square > 0) widest = std::fmax(widest, (range.high - range.low) / numbers.scale());
    meet += square == 0 ? 1u : 0u;
    ++pairs;
    // The points are on both, up to their rounding, and as far.
    const NearestPair near = nearest_pair(corners_of(a), b);
    const ExactPoint p = oracle::exact_point(near.on_a), q = oracle::exact_point(near.on_b);
    const mpq_class tiny = mpq_class(numbers.scale()) * mpq_class(0x1p-48);
    ASSERT_LE(oracle::hull_square_distance({p}, exact_corners(a)), tiny * tiny)
        << "round " << round;
    ASSERT_LE(oracle::hull_square_distance({q}, exact_corners(b)), tiny * tiny)
        << "round " << round;
    const double apart =
        std::sqrt(mpq_class(oracle::hull_square_distance({p}, {q}) /
                            (mpq_class(numbers.scale()) * mpq_class(numbers.scale())))
                      .get_d());
    ASSERT_NEAR(apart, distance.rounded() / numbers.scale(), 0x1p-45) << "round " << round;
  }
  std::printf("%zu pairs: meet %zu, wrong 0, widest interval of those apart 2^%.1f\n", pairs, meet,
              std::log2(widest));
  EXPECT_GT(meet, test::random_cases(300u));
}

TEST(Regions, touch_and_miss_by_one_unit_in_the_last_place) {
  const Triangle t{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};
  // An axis 5 away from the edge x = 0 at (-3, *, 4), one that goes through, one beside the corner.
  for (const auto& [from, to, distance] :
       {std::tuple{Vec3d{-3, 2, 4}, Vec3d{-3, 6, 4}, 5.0},
        std::tuple{Vec3d{1, 1, -9}, Vec3d{1, 1, 9}, 0.0},
        std::tuple{Vec3d{-3, -4, 12}, Vec3d{-3, -4, 30}, 13.0}}) {
    EXPECT_TRUE(triangle_meets_box(t, Capsule{from, to, distance}));
    if (distance == 0) continue;
    EXPECT_FALSE(triangle_meets_box(t, Capsule{from, to, std::nextafter(distance, 0.0)}));
  }
  // The corner (8,0,0) lies in the plane x = 8; x + y = 8 is the long edge.
  const HalfSpace beyond{{-1, 0, 0}, -8}, farther{{-1, 0, 0}, -std::nextafter(8.0, 9.0)};
  EXPECT_TRUE(triangle_meets_box(t, ConvexRegion{{&beyond, 1}}));
  EXPECT_FALSE(triangle_meets_box(t, ConvexRegion{{&farther, 1}}));
  const std::vector<HalfSpace> edge{
      {{-1, -1, 0}, -8}, {{0, 1, 0}, 4}, {{0, -1, 0}, -4}, {{1, 0, 0}, 4}};
  EXPECT_TRUE(triangle_meets_box(t, ConvexRegion{edge})) << "the one point (4,4,0)";
  EXPECT_FALSE(triangle_meets_box({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, ConvexRegion{{&edge[1], 1}}))
      << "no area";
}

}  // namespace
}  // namespace sightline
