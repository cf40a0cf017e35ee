#include "core/geometry/dyadic.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

namespace sightline {
namespace {

/// A finite float64 of any exponent, or one from a narrow range, so that cancellation happens too.
double any_finite(std::mt19937_64& random) {
  for (;;) {
    const auto bits = random();
    if ((bits & 3) == 0)
      return static_cast<double>(static_cast<std::int64_t>(random() % 33) - 16) * 0.25;
    const double x = std::bit_cast<double>(random());
    if (std::isfinite(x)) return x;
  }
}

/// Exact comparison of a Dyadic with a GMP rational through differences that must vanish.
int sign_of(const mpq_class& q) { return sgn(q); }

TEST(Dyadic, agrees_with_gmp_on_sums_products_and_signs) {
  constexpr std::uint64_t kSeed = 20261121;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 20000; ++i) {
    const double a = any_finite(random), b = any_finite(random), c = any_finite(random),
                 d = any_finite(random);
    const Dyadic x = (Dyadic(a) - Dyadic(b)) * Dyadic(c) + Dyadic(d) * Dyadic(a);
    const mpq_class y = (mpq_class(a) - mpq_class(b)) * mpq_class(c) + mpq_class(d) * mpq_class(a);
    ASSERT_EQ(x.sign(), sign_of(y)) << a << ' ' << b << ' ' << c << ' ' << d;
    const Dyadic z = Dyadic(b) * Dyadic(d);
    ASSERT_EQ(compare(x, z), sign_of(y - mpq_class(b) * mpq_class(d)));
  }
}

/// Correct rounding told by its definition: no other float64 is nearer, and a tie is even.
void expect_nearest(const mpq_class& exact, double rounded) {
  if (std::isinf(rounded)) {
    const mpq_class edge = mpq_class(std::numeric_limits<double>::max()) * 2 -
                           mpq_class(std::nextafter(std::numeric_limits<double>::max(), 0.0));
    const mpq_class middle = (edge + mpq_class(std::numeric_limits<double>::max())) / 2;
    EXPECT_GE(abs(exact), middle);
    return;
  }
  const mpq_class error = abs(exact - mpq_class(rounded));
  for (const double direction : {-INFINITY, INFINITY}) {
    const double other = std::nextafter(rounded, direction);
    if (std::isinf(other)) continue;
    const mpq_class other_error = abs(exact - mpq_class(other));
    ASSERT_LE(error, other_error);
    if (error == other_error) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(rounded) & 1, 0u);
    }
  }
}

TEST(Dyadic, rounds_a_quotient_to_the_nearest_float64) {
  constexpr std::uint64_t kSeed = 7;
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 20000; ++i) {
    const double a = any_finite(random), b = any_finite(random), c = any_finite(random);
    double d = any_finite(random);
    if (d == 0) d = 3;
    const Dyadic numerator = Dyadic(a) * Dyadic(b) - Dyadic(c);
    const mpq_class exact = (mpq_class(a) * mpq_class(b) - mpq_class(c)) / mpq_class(d);
    expect_nearest(exact, round_quotient(numerator, Dyadic(d)));
  }
}

TEST(FixedT, is_rounded_and_approximated_as_by_wide_numbers) {
  std::mt19937_64 random(5);
  const auto integer = [&](int limbs) {
    Int256 value;
    for (int i = 0; i < limbs; ++i) value.limb[static_cast<std::size_t>(i)] = random();
    // Few bits make ratios that are float64 numbers, or in the middle of two.
    if (random() % 4 == 0) value = {{random() % 64, 0, random() % 3, 0}};
    if (limbs == 4) value.limb[3] >>= 1;
    return random() % 2 == 0 ? value : -value;
  };
  int certain = 0, exact = 0;
  for (int i = 0; i < 200'000; ++i) {
    FixedT t{integer(1 + i % 4), integer(1 + i / 4 % 4), static_cast<int>(random() % 2400) - 1200};
    if (i % 3 == 0) t.exponent %= 60;
    if (i % 5 == 0) {
      // Within two units of the middle of two float64 numbers.
      t.denominator = {{1, 0, 0, 0}};
      t.numerator = {
          {(std::uint64_t{1} << 63 | random() << 11 | 1u << 10) + random() % 5 - 2, 0, 0, 0}};
    }
    if (t.denominator.sign() == 0) continue;
    const Dyadic numerator(t.numerator, t.exponent), denominator(t.denominator, 0);
    const double wide = round_quotient(numerator, denominator);
    if (const auto rounded = certain_rounding(t)) {
      ++certain;
      ASSERT_EQ(std::bit_cast<std::uint64_t>(*rounded), std::bit_cast<std::uint64_t>(wide)) << i;
      exact +=
          mpq_class(*rounded) == 0 ? 0 : compare(Dyadic(*rounded) * denominator, numerator) == 0;
    }
    const double near = approximate_quotient(t);
    if (std::isinf(wide) || std::isinf(near)) continue;
    ASSERT_LE(std::abs(near - wide), 0x1p-49 * std::abs(wide) + 0x1p-1073) << i;
  }
  EXPECT_GT(certain, 100'000);
  EXPECT_GT(exact, 100);
}

TEST(Dyadic, rounds_ties_to_even_and_underflows_gradually) {
  const Dyadic one(1.0);
  EXPECT_EQ(round_quotient(Dyadic(9007199254740993.0 - 1) + one, one), 9007199254740992.0);
  const double least = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(round_quotient(Dyadic(least), Dyadic(2.0)), 0.0);
  EXPECT_EQ(round_quotient(Dyadic(least) * Dyadic(3.0), Dyadic(2.0)), 2 * least);
  EXPECT_TRUE(std::signbit(round_quotient(Dyadic(-least), Dyadic(2.0)))) << "as IEEE 754 rounds";
  EXPECT_FALSE(std::signbit(round_quotient(Dyadic(-0.0), Dyadic(-2.0)))) << "exactly zero is +0";
  const double most = std::numeric_limits<double>::max();
  EXPECT_TRUE(std::isinf(round_quotient(Dyadic(most) * Dyadic(2.0), one)));
  EXPECT_EQ(round_quotient(Dyadic(most) + Dyadic(1.0), one), most);
}

TEST(Dyadic, rounds_a_component_of_a_unit_vector_of_any_size) {
  constexpr std::uint64_t kSeed = 8;
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 20000; ++i) {
    const double a = any_finite(random), b = any_finite(random), c = any_finite(random);
    if (a == 0 && b == 0 && c == 0) continue;
    const Dyadic square = Dyadic(a) * Dyadic(a) + Dyadic(b) * Dyadic(b) + Dyadic(c) * Dyadic(c);
    const double rounded = round_over_root(Dyadic(a), square);
    // rounded^2 |v|^2 against a^2 at both midpoints tells that no other float64 is nearer.
    const mpq_class a2 = mpq_class(a) * mpq_class(a);
    const mpq_class s2 = a2 + mpq_class(b) * mpq_class(b) + mpq_class(c) * mpq_class(c);
    const mpq_class size = abs(mpq_class(rounded));
    const mpq_class above = (size + mpq_class(std::nextafter(std::abs(rounded), 2.0))) / 2;
    ASSERT_LE(a2, above * above * s2) << a << ' ' << b << ' ' << c;
    if (rounded == 0) continue;
    ASSERT_EQ(std::signbit(rounded), std::signbit(a));
    const mpq_class below = (size + mpq_class(std::nextafter(std::abs(rounded), 0.0))) / 2;
    ASSERT_GE(a2, below * below * s2) << a << ' ' << b << ' ' << c;
  }
}

}  // namespace
}  // namespace sightline
