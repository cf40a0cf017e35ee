#pragma once
/// Numbers of JSON as nearly everybody writes them, several digits at a time.

#include <fast_float/fast_float.h>

#include <bit>
#include <cstdint>
#include <cstring>

namespace sightline {

/// What has to be readable behind a text that is scanned, after a byte that is no digit.
inline constexpr std::size_t kPlainPadding = 32;

namespace plain {

static_assert(std::endian::native == std::endian::little, "the first digit is the lowest byte");

/// Some digits of eight bytes.
struct Digits {
  std::uint64_t values;  ///< of the bytes; of digits 0 to 9
  unsigned count;        ///< of digits that come first
};

inline Digits digits_at(const char* at) {
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, at, sizeof bytes);
  const std::uint64_t values = bytes ^ 0x3030303030303030u;
  // A byte beyond 9 sets its highest bit; what it carries into goes no digit before it.
  const std::uint64_t others = ((values + 0x7676767676767676u) | values) & 0x8080808080808080u;
  return {values, others == 0 ? 8u : static_cast<unsigned>(std::countr_zero(others)) / 8};
}

/// The number that they are. Precondition: there is one at least.
inline std::uint64_t value_of(const Digits& digits) {
  constexpr std::uint64_t kPairs = 10, kTwoPairs = 100, kFourPairs = 10000;
  std::uint64_t v = digits.values << (8 * (8 - digits.count));
  v = (v * kPairs + (v >> 8)) & 0x00ff00ff00ff00ffu;
  v = (v * kTwoPairs + (v >> 16)) & 0x0000ffff0000ffffu;
  return (v * kFourPairs + (v >> 32)) & 0xffffffffu;
}

inline constexpr std::uint64_t kPowers[] = {1,      10,      100,      1000,     10000,
                                            100000, 1000000, 10000000, 100000000};

/// Digits from `at` on are appended to `value`, which may overflow. Returns how many.
inline unsigned append_digits(const char*& at, std::uint64_t& value) {
  unsigned all = 0;
  for (;;) {
    const Digits digits = digits_at(at);
    if (digits.count == 0) return all;
    value = value * kPowers[digits.count] + value_of(digits);
    at += digits.count;
    all += digits.count;
    if (digits.count < 8) return all;
  }
}

/// How many of `digits` digits, with a point somewhere among them, are more than zeros in front.
inline unsigned significant_digits(const char* at, unsigned digits) {
  for (; *at == '0' || *at == '.'; ++at) digits -= *at == '0' ? 1 : 0;
  return digits;
}

}  // namespace plain

/// Reads the number at `at` as the nearest float64 and moves `at` behind it. False, with `at`
/// anywhere, for what has to be looked at more closely: what is no number of JSON, more than 19
/// digits that matter, what overflows.
inline bool scan_plain_number(const char*& at, double& out) {
  constexpr unsigned kMostDigits = 19, kMostExponentDigits = 4;
  const bool negative = *at == '-';
  at += negative ? 1 : 0;
  const char* const begin = at;
  std::uint64_t significand = 0;
  unsigned digits = plain::append_digits(at, significand);
  if (digits == 0 || (digits > 1 && *begin == '0')) return false;
  std::int64_t exponent = 0;
  if (*at == '.') {
    const unsigned fraction = plain::append_digits(++at, significand);
    if (fraction == 0) return false;
    digits += fraction;
    exponent = -static_cast<std::int64_t>(fraction);
  }
  if (digits > kMostDigits && plain::significant_digits(begin, digits) > kMostDigits) return false;
  if (*at == 'e' || *at == 'E') {
    ++at;
    const bool down = *at == '-';
    at += *at == '-' || *at == '+' ? 1 : 0;
    std::uint64_t power = 0;
    const unsigned count = plain::append_digits(at, power);
    if (count == 0 || count > kMostExponentDigits) return false;
    exponent += down ? -static_cast<std::int64_t>(power) : static_cast<std::int64_t>(power);
  }
  // [Lemire2021]: exact for 19 digits, or it says that it cannot tell.
  using Float64 = fast_float::binary_format<double>;
  std::uint64_t bits = 0;
  if (significand != 0) {
    const fast_float::adjusted_mantissa found =
        fast_float::compute_float<Float64>(exponent, significand);
    if (found.power2 < 0 || found.power2 >= Float64::infinite_power()) return false;
    bits = found.mantissa | static_cast<std::uint64_t>(found.power2)
                                << Float64::mantissa_explicit_bits();
  }
  out = std::bit_cast<double>(bits | static_cast<std::uint64_t>(negative) << 63);
  return true;
}

}  // namespace sightline
