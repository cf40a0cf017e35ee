// Numbers as text, held against the standard library's.

#include "proto/json/number_text.h"

#include <gtest/gtest.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

void expect_as_usual(double value) {
  std::array<char, kNumberRoom> ours{}, theirs{};
  const std::string text(ours.data(), write_float64(ours.data(), value));
  ASSERT_EQ(text, std::string(theirs.data(),
                              std::to_chars(theirs.data(), theirs.data() + kNumberRoom, value).ptr))
      << std::hexfloat << value;
}

/// The value and its neighbours, of both signs.
void expect_around(double value) {
  for (const double each : {value, std::nextafter(value, 0.0), std::nextafter(value, HUGE_VAL)}) {
    if (!std::isfinite(each)) continue;
    expect_as_usual(each);
    expect_as_usual(-each);
  }
}

void expect_integer_as_usual(std::uint64_t value) {
  std::array<char, kNumberRoom> text{};
  ASSERT_EQ(std::string(text.data(), write_integer(text.data(), value)), std::to_string(value));
}

TEST(NumberText, is_the_shortest_of_every_exponent) {
  oracle::Random random(41);
  constexpr int kLeastExponent = -1074, kMostExponent = 1023;
  for (int exponent = kLeastExponent; exponent <= kMostExponent; ++exponent) {
    expect_around(std::ldexp(1.0, exponent));
    // Where there is more than one way to write them most are tried.
    const int count = test::random_cases(exponent >= -12 && exponent <= 54 ? 20'000 : 40);
    for (int i = 0; i < count; ++i) expect_as_usual(std::ldexp(1 + random.unit(), exponent));
  }
  expect_around(0);
  expect_around(std::numeric_limits<double>::max());
}

TEST(NumberText, is_the_shortest_where_few_digits_are_enough) {
  oracle::Random random(42);
  for (int i = 0; i < test::random_cases(20'000); ++i) {
    const double value = random.between(-1, 1) * std::ldexp(1.0, random.integer(-10, 50));
    expect_around(static_cast<double>(static_cast<float>(value)));
    for (const double places : {1.0, 10.0, 100.0, 1e3, 1e6, 1e9, 64.0, 3.0}) {
      expect_around(std::round(value * places) / places);
    }
  }
  for (int i = 0; i < 200'000; i += 7) expect_around(i);
}

TEST(NumberText, writes_integers_in_full) {
  for (std::uint64_t power = 1; power < std::uint64_t{1} << 60; power *= 10) {
    for (const std::uint64_t value : {power - 1, power, power + 1, power * 2}) {
      expect_integer_as_usual(value);
    }
  }
  expect_integer_as_usual(std::numeric_limits<std::uint64_t>::max());
  oracle::Random random(43);
  for (int i = 0; i < test::random_cases(200'000); ++i) {
    expect_integer_as_usual(random.bits() >> random.integer(0, 63));
  }
}

}  // namespace
}  // namespace sightline
