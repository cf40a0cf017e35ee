#include "tests/oracle/rational.h"

#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>
#include <limits>

#include "core/base/infinity.h"
#include "tests/oracle/random.h"
#include "tests/support/float_text.h"
#include "tests/support/random_cases.h"

namespace sightline::oracle {
namespace {

using test::same_bits;
constexpr double kMax = std::numeric_limits<double>::max();
constexpr double kDenormal = std::numeric_limits<double>::denorm_min();

Rational fraction(double num, double den) {
  const Rational a = exact(num);
  const Rational b = exact(std::fabs(den));
  return {den < 0 ? mpz_class(-a.num) : a.num, b.num, a.shift - b.shift};
}

TEST(Rational, holds_every_float64_exactly) {
  Random random(1);
  for (int i = 0; i < test::random_cases(200000); ++i) {
    const double value = random.any_double();
    ASSERT_EQ(to_mpq(exact(value)), mpq_class(value)) << value;
    if (value != 0) {
      ASSERT_TRUE(same_bits(round_to_double(exact(value)), value)) << value;
    }
  }
}

TEST(Rational, rounds_quotients_as_the_hardware_does) {
  // Division of float64 numbers is correctly rounded, denormal and overflowing results included.
  Random random(2);
  for (int i = 0; i < test::random_cases(400000); ++i) {
    const double a = random.any_double();
    double b = random.any_double();
    if (i % 2 == 0) b = std::ldexp(random.between(1, 2), random.integer(-60, 60));
    if (a == 0 || b == 0) continue;
    ASSERT_TRUE(same_bits(round_to_double(fraction(a, b)), a / b)) << a << " / " << b;
  }
}

TEST(Rational, rounds_quotients_near_the_denormals_once) {
  Random random(3);
  for (int i = 0; i < test::random_cases(200000); ++i) {
    const double a = static_cast<double>(random.integer(1, 4000)) * kDenormal;
    const double b = random.chance(0.5) ? random.between(0.25, 64) : random.integer(1, 64);
    ASSERT_TRUE(same_bits(round_to_double(fraction(-a, b)), -a / b)) << a << " / " << b;
  }
}

TEST(Rational, rounds_ties_to_even) {
  EXPECT_EQ(round_to_double({(mpz_class(1) << 54) + 2, 1, 0}), std::ldexp(1, 54));
  EXPECT_EQ(round_to_double({(mpz_class(1) << 54) + 6, 1, 0}), std::ldexp(1, 54) + 8);
  EXPECT_EQ(round_to_double({1, 1, -1075}), 0.0);
  EXPECT_EQ(round_to_double({3, 1, -1075}), 2 * kDenormal);
  EXPECT_EQ(round_to_double({(mpz_class(1) << 200) + 1, mpz_class(1) << 200, -1075}), kDenormal);
}

TEST(Rational, rounds_what_exceeds_the_range_to_infinity_and_zero_to_plus_zero) {
  EXPECT_EQ(round_to_double({(mpz_class(1) << 54) - 1, 1, 970}), kInf);
  EXPECT_EQ(round_to_double({((mpz_class(1) << 54) - 1) * 8 - 1, 1, 967}), kMax);
  EXPECT_EQ(round_to_double({-1, 1, 1024}), -kInf);
  EXPECT_EQ(round_to_double({-1, 1, 90000}), -kInf);
  EXPECT_TRUE(same_bits(round_to_double({0, 7, 3}), 0.0));
  EXPECT_TRUE(same_bits(round_to_double({-1, 3, -1075}), -0.0));
  EXPECT_TRUE(same_bits(round_to_double({1, 1, -90000}), 0.0));
}

TEST(Rational, compares_as_mpq_does) {
  Random random(4);
  for (int i = 0; i < test::random_cases(100000); ++i) {
    const double a = random.chance(0.5) ? random.any_double() : random.integer(-3, 3);
    const double b = random.chance(0.5) ? random.any_double() : random.integer(1, 3);
    const double c = random.chance(0.5) ? random.any_double() : random.integer(-3, 3);
    const double d = random.chance(0.5) ? random.any_double() : random.integer(1, 3);
    if (b == 0 || d == 0) continue;
    const Rational x = fraction(a, b);
    const Rational y = fraction(c, d);
    const int truth = cmp(mpq_class(a) / mpq_class(b), mpq_class(c) / mpq_class(d));
    ASSERT_EQ(compare(x, y), truth < 0 ? -1 : truth > 0 ? 1 : 0);
    ASSERT_EQ(compare(x, kInf), -1);
    ASSERT_EQ(compare(x, -kInf), 1);
  }
}

TEST(Rational, knows_the_ulp_of_every_binade) {
  EXPECT_EQ(ulp_exponent(1), -52);
  EXPECT_EQ(ulp_exponent(mpq_class(-3, 2)), -52);
  EXPECT_EQ(ulp_exponent(mpq_class(2) - mpq_class(1, 1000000007)), -52);
  EXPECT_EQ(ulp_exponent(mpq_class(1) - mpq_class(1, 1000000007)), -53);
  EXPECT_EQ(ulp_exponent(mpq_class(kMax)), 971);
  EXPECT_EQ(ulp_exponent(mpq_class(kDenormal)), -1074);
  EXPECT_EQ(ulp_exponent(0), -1074);
}

}  // namespace
}  // namespace sightline::oracle
