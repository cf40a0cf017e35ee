// Numbers read several digits at a time, held against the C library's reader.

#include "proto/json/plain_number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "tests/oracle/random.h"

namespace sightline {
namespace {

/// What is read of a text, if all of it is.
std::optional<double> scan(const std::string& text) {
  std::string padded = text + "]";
  padded.reserve(padded.size() + kPlainPadding);
  const char* at = padded.data();
  double value = 0;
  if (!scan_plain_number(at, value) || at != padded.data() + text.size()) return std::nullopt;
  return value;
}

std::string print(const char* form, double value) {
  char text[400];
  std::snprintf(text, sizeof text, form, value);
  return text;
}

void expect_read(const std::string& text) {
  const double value = std::strtod(text.c_str(), nullptr);
  const auto found = scan(text);
  ASSERT_TRUE(found) << text;
  EXPECT_EQ(std::bit_cast<std::uint64_t>(*found), std::bit_cast<std::uint64_t>(value)) << text;
}

TEST(PlainNumber, is_the_nearest_float64_of_any_digits) {
  oracle::Random random(31);
  for (int i = 0; i < 100'000; ++i) {
    const double any = random.any_double();
    expect_read(print("%.17g", any));
    expect_read(print("%.16e", any));
    const double usual = random.between(-1000, 1000);
    for (const char* form : {"%.17g", "%.6f", "%.0f", "%.15f"}) expect_read(print(form, usual));
  }
}

TEST(PlainNumber, is_the_nearest_float64_wherever_its_point_and_its_end_are) {
  oracle::Random random(32);
  for (std::size_t whole = 1; whole <= 10; ++whole) {
    for (std::size_t fraction = 1; fraction <= 21; ++fraction) {
      for (int i = 0; i < 100; ++i) {
        std::string text;
        for (std::size_t k = 0; k < whole + fraction; ++k) {
          if (k == whole) text += '.';
          // The first digit of several is not zero; many of the others are.
          const char least = k == 0 && whole > 1 ? '1' : '0';
          text += random.chance(0.3) ? least : static_cast<char>(random.integer(least, '9'));
        }
        // More than 19 digits behind leading zeros are left to the slower reader.
        std::size_t zeros = text.find_first_not_of("0.");
        zeros = zeros == std::string::npos ? whole + fraction : zeros > whole ? zeros - 1 : zeros;
        if (whole + fraction - zeros > 19) continue;
        expect_read(text);
        expect_read("-" + text);
        expect_read(text + "e-" + std::to_string(random.index(340)));
      }
    }
  }
}

TEST(PlainNumber, is_the_nearest_float64_next_to_halfway) {
  oracle::Random random(33);
  for (int i = 0; i < 100'000; ++i) {
    const double below = std::ldexp(random.between(0.5, 1), random.integer(-50, 19));
    const long double halfway =
        (static_cast<long double>(below) + std::nextafter(below, HUGE_VAL)) / 2;
    char text[60];
    std::snprintf(text, sizeof text, "%.18Lg", halfway);
    expect_read(text);
    std::snprintf(text, sizeof text, "%.17Lf", halfway);
    if (below < 10) expect_read(text);
  }
}

TEST(PlainNumber, is_read_at_the_ends_of_the_range_and_halfway) {
  for (const char* text :
       {"0", "-0", "0.0", "-0.0e7", "1", "12345678", "123456789012345678", "9007199254740993",
        "0.00000000000000000000012345678901234567", "4.9406564584124654e-324",
        "2.2250738585072014E-308", "1.7976931348623157e+308", "1e22", "1e-5", "0e9999", "8.41e21",
        "5e-324"}) {
    expect_read(text);
  }
}

TEST(PlainNumber, is_left_to_the_slower_reader_where_it_is_none_or_not_plain) {
  for (const char* text : {"",
                           "-",
                           "+1",
                           ".5",
                           "1.",
                           "01",
                           "-00",
                           "00.5",
                           "1e",
                           "1e+",
                           "1.e5",
                           "1e99999",
                           "1e999",
                           "-1e999",
                           "nan",
                           "Infinity",
                           "0x10",
                           "--1",
                           "1 2",
                           "1,5",
                           "1_000",
                           "12345678901234567890",
                           "0.12345678901234567890123"}) {
    EXPECT_FALSE(scan(text)) << text;
  }
}

}  // namespace
}  // namespace sightline
