#include "core/query/ray_batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/infinity.h"
#include "core/query/ray_generators.h"
#include "tests/oracle/random.h"
#include "tests/oracle/rational.h"

namespace sightline {
namespace {

TEST(RayDistance, is_t_times_the_length_of_the_direction) {
  EXPECT_EQ(distance_of(2, {3, 0, 4}), 10);
  EXPECT_EQ(distance_of(-2, {0, -5, 0}), -10);
  EXPECT_EQ(distance_of(kInf, {3, 0, 4}), kInf);
  EXPECT_EQ(distance_of(0x1p-1000, {3 * 0x1p1000, 0, 4 * 0x1p1000}), 5);
  EXPECT_EQ(distance_of(0x1p1000, {0, 0x1p-1074, 0}), 0x1p-74);
  const double most = std::numeric_limits<double>::max();
  EXPECT_NEAR(distance_of(0x1p-1023, {most, most, most}), 2 * std::sqrt(3.0), 1e-15);
}

/// Whether `got` is within 2^-51 of t * |d|, by rational arithmetic.
bool is_within_bound(double got, const mpq_class& t, const Vec3d& d) {
  const mpq_class exact_square =
      t * t * (mpq_class(d.x) * d.x + mpq_class(d.y) * d.y + mpq_class(d.z) * d.z);
  // |got / exact - 1| <= 2^-51 follows from |got^2 / exact^2 - 1| <= 2^-50.
  const mpq_class error = abs(mpq_class(mpq_class(got) * got / exact_square - 1));
  return error <= mpq_class(0x1p-50);
}

TEST(RayDistance, is_within_its_bound_of_the_exact_length) {
  oracle::Random random(4);
  for (int i = 0; i < 20000; ++i) {
    const double scale = std::ldexp(1.0, random.integer(-300, 300));
    const Vec3d d{random.between(-1, 1) * scale, random.between(-1, 1) * scale,
                  random.between(-1, 1) * scale * (i % 2 == 0 ? 1 : 0x1p-30)};
    const double t = random.between(0.1, 1) / scale;
    ASSERT_TRUE(is_within_bound(distance_of(t, d), t, d)) << i;
  }
}

TEST(RayDistance, is_within_its_bound_where_t_is_subnormal_or_near_the_largest) {
  EXPECT_EQ(distance_of(0x1p-1074, {0x1.8p100, 0, 0}), 0x1.8p-974);
  EXPECT_EQ(distance_of(0x1.8p1023, {0x1.8p-100, 0, 0}), 0x1.2p924);
  oracle::Random random(6);
  for (int i = 0; i < 20000; ++i) {
    const bool is_small = i % 2 == 0;
    const double t = is_small ? std::ldexp(random.between(0.5, 1), random.integer(-1073, -1020))
                              : std::ldexp(random.between(0.5, 1), random.integer(1020, 1024));
    const double scale =
        std::ldexp(1.0, is_small ? random.integer(60, 1020) : random.integer(-990, -20));
    const Vec3d d{random.between(0.1, 1) * scale, random.between(-1, 1) * scale,
                  random.between(-1, 1) * scale};
    ASSERT_TRUE(is_within_bound(distance_of(t, d), t, d)) << i << " t " << t;
  }
}

TEST(RayDistance, turns_limits_into_limits_of_t_within_the_bound_at_every_scale) {
  oracle::Random random(7);
  for (int i = 0; i < 20000; ++i) {
    const bool is_small = i % 2 == 0;
    const double limit = is_small ? std::ldexp(random.between(0.5, 1), random.integer(-1073, -1020))
                                  : std::ldexp(random.between(0.5, 1), random.integer(1020, 1024));
    const double scale =
        std::ldexp(1.0, is_small ? random.integer(-1020, -60) : random.integer(20, 1000));
    const Vec3d d{random.between(0.1, 1) * scale, random.between(-1, 1) * scale,
                  random.between(-1, 1) * scale};
    RayBatch rays;
    rays.push_back({{0, 0, 0}, d, limit, limit});
    scale_limits_to_t(rays);
    ASSERT_TRUE(is_within_bound(limit, rays.tmin[0], d)) << i << " limit " << limit;
  }
}

TEST(RayDistance, turns_limits_into_limits_of_t) {
  RayBatch rays;
  rays.push_back({{0, 0, 0}, {3, 0, 4}, -5, 10});
  rays.push_back({{0, 0, 0}, {1e308, 1e308, 1e308}, 0, kInf});
  scale_limits_to_t(rays);
  EXPECT_EQ(rays.tmin[0], -1);
  EXPECT_EQ(rays.tmax[0], 2);
  EXPECT_EQ(rays.tmin[1], 0);
  EXPECT_EQ(rays.tmax[1], kInf);
}

TEST(SinCosDegrees, are_within_their_bound_and_exact_at_right_angles) {
  for (const auto& [degrees, sine, cosine] : {std::tuple{0.0, 0.0, 1.0},
                                              {90.0, 1.0, 0.0},
                                              {180.0, 0.0, -1.0},
                                              {-90.0, -1.0, 0.0},
                                              {270.0, -1.0, 0.0},
                                              {3600.0, 0.0, 1.0},
                                              {-450.0, -1.0, 0.0}}) {
    EXPECT_EQ(sin_cos_degrees(degrees).sin, sine) << degrees;
    EXPECT_EQ(sin_cos_degrees(degrees).cos, cosine) << degrees;
  }
  oracle::Random random(5);
  constexpr long double kPi = 3.14159265358979323846264338327950288L;
  for (int i = 0; i < 100000; ++i) {
    const double degrees = random.between(-720, 720);
    const long double radians = static_cast<long double>(degrees) * kPi / 180;
    ASSERT_NEAR(static_cast<double>(sin_cos_degrees(degrees).sin - std::sin(radians)), 0, 0x1p-52);
    ASSERT_NEAR(static_cast<double>(sin_cos_degrees(degrees).cos - std::cos(radians)), 0, 0x1p-52);
  }
}

}  // namespace
}  // namespace sightline
