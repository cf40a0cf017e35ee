#pragma once
/// Reads JSON numbers in their usual form, several digits at a time. scan_plain_number is the
/// interface; namespace plain has its parts. The slow reader is JsonReader::read_number, which the
/// caller uses if this returns false.

#include <fast_float/fast_float.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace sightline {

/// The number of bytes that must be readable after the end of a scanned text. The first of them
/// must not be a digit, so that a number ends with the text. The others may be anything.
inline constexpr std::size_t kPlainPadding = 32;

namespace plain {

static_assert(std::endian::native == std::endian::little, "the first digit is the lowest byte");

/// Eight bytes of text as the "values" of the functions below: digits become 0 to 9, other bytes
/// are above 9. The first byte is the lowest.
inline std::uint64_t values_at(const char* at) {
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, at, sizeof bytes);
  return bytes ^ 0x3030303030303030u;
}

/// Marks the bytes of `values` that are not digits by their highest bit. Only the lowest mark is
/// certain: marks of higher bytes may be wrong.
inline std::uint64_t others_of(std::uint64_t values) {
  // Adding sets the highest bit of a byte above 9. A carry reaches only later bytes.
  return ((values + 0x7676767676767676u) | values) & 0x8080808080808080u;
}

/// The number of bytes before the first marked byte of others_of. Precondition: there is a mark.
inline unsigned bytes_before(std::uint64_t others) {
  return static_cast<unsigned>(std::countr_zero(others)) / 8;
}

/// The number that eight digits form, the first digit in the lowest byte.
[[gnu::always_inline]] inline std::uint64_t value_of(std::uint64_t values) {
  constexpr std::uint64_t kPairs = 10, kTwoPairs = 100, kFourPairs = 10000;
  std::uint64_t v = values;
  v = (v * kPairs + (v >> 8)) & 0x00ff00ff00ff00ffu;
  v = (v * kTwoPairs + (v >> 16)) & 0x0000ffff0000ffffu;
  return (v * kFourPairs + (v >> 32)) & 0xffffffffu;
}

/// The first `count` of eight digits, moved to the end, with zeros before them. So value_of gives
/// the number that they form.
inline std::uint64_t first_digits(std::uint64_t values, unsigned count) {
  // Two shifts, because a shift by 64 is not defined.
  return values << (4 * (8 - count)) << (4 * (8 - count));
}

inline constexpr std::uint64_t kPowers[] = {1,      10,      100,      1000,     10000,
                                            100000, 1000000, 10000000, 100000000};

/// Appends the digits from `at` on to the decimal digits of `value`, which wraps around on
/// overflow. Moves `at` to the first byte that is no digit. Returns how many digits there were.
inline unsigned append_digits(const char*& at, std::uint64_t& value) {
  unsigned all = 0;
  for (;;) {
    const std::uint64_t values = values_at(at), others = others_of(values);
    const unsigned count = others == 0 ? 8 : bytes_before(others);
    if (count == 0) return all;
    value = value * kPowers[count] + value_of(first_digits(values, count));
    at += count;
    all += count;
    if (count < 8) return all;
  }
}

/// The number of digits without leading zeros. `at` is a text of `digits` digits that may contain a
/// point. Precondition: a byte other than "0" and "." follows the text.
inline unsigned significant_digits(const char* at, unsigned digits) {
  for (; *at == '0' || *at == '.'; ++at) digits -= *at == '0' ? 1 : 0;
  return digits;
}

/// A decimal number without its sign: significand * 10^exponent.
struct Decimal {
  std::uint64_t significand = 0;
  std::int64_t exponent = 0;
};

/// Sets `out` to the float64 that is nearest to `decimal`, with the sign of `negative`. Returns
/// false if that cannot be determined, or overflows. Precondition: at most 19 significant digits.
inline bool nearest_float64(const Decimal& decimal, bool negative, double& out) {
  // [Lemire2021]: exact for 19 digits, or it reports that it cannot decide.
  using Float64 = fast_float::binary_format<double>;
  std::uint64_t bits = 0;
  if (decimal.significand != 0) {
    const fast_float::adjusted_mantissa found =
        fast_float::compute_float<Float64>(decimal.exponent, decimal.significand);
    if (found.power2 < 0 || found.power2 >= Float64::infinite_power()) return false;
    bits = found.mantissa | static_cast<std::uint64_t>(found.power2)
                                << Float64::mantissa_explicit_bits();
  }
  out = std::bit_cast<double>(bits | static_cast<std::uint64_t>(negative) << 63);
  return true;
}

/// nearest_float64 for exponents of -18 to -12. In that range float64 neither overflows nor
/// underflows, and no number is halfway between two float64 numbers: by [Lemire2021] that needs an
/// exponent of at least -4. Also returns false for zero, and if the first 64 bits of the power of
/// five do not determine the rounding.
[[gnu::always_inline]] inline bool nearest_of_19_digits(const Decimal& decimal, bool negative,
                                                        double& out) {
  using Float64 = fast_float::binary_format<double>;
  using Powers = fast_float::powers;
  constexpr int kMantissaBits = Float64::mantissa_explicit_bits();
  constexpr std::uint64_t kUnknownBits = 0x1ff;
  const int zeros = std::countl_zero(decimal.significand | 1);
  const auto power = static_cast<int>(decimal.exponent);
  const fast_float::value128 product = fast_float::full_multiplication(
      decimal.significand << zeros,
      Powers::power_of_five_128[2 * std::ptrdiff_t{power - Powers::smallest_power_of_five}]);
  if ((product.high & kUnknownBits) == kUnknownBits || decimal.significand == 0) return false;
  const int more = static_cast<int>(product.high >> 63);
  const std::uint64_t mantissa = product.high >> (more + 64 - kMantissaBits - 3);
  const int exponent =
      fast_float::detail::power(power) + more - zeros - Float64::minimum_exponent();
  // The first bit of the mantissa is implicit in a float64, and a carry of the rounding increments
  // the exponent.
  const std::uint64_t bits = (static_cast<std::uint64_t>(exponent - 1) << kMantissaBits) +
                             ((mantissa + (mantissa & 1)) >> 1);
  out = std::bit_cast<double>(bits | static_cast<std::uint64_t>(negative) << 63);
  return true;
}

/// A mask of the bytes before the first marked byte of others_of; all bytes if there is no mark.
inline std::uint64_t bytes_kept(std::uint64_t others) {
  return ((others & (~others + 1)) >> 7) - 1;
}

/// Reads a decimal in the form in which most float64 numbers are printed: digits with a point among
/// the first eight bytes, at most 19 digits, no sign, no exponent. Sets `out` as if zeros followed
/// up to 19 digits, so its exponent is -18 to -12. Returns the end, or null for other forms. The
/// end does not depend on the value, so a processor can begin the next number in parallel.
[[gnu::always_inline]] inline const char* scan_usual_decimal(const char* at, Decimal& out) {
  constexpr unsigned kDigits = 19;
  const std::uint64_t begin = values_at(at), others = others_of(begin);
  const unsigned point = others == 0 ? 0 : bytes_before(others);
  if (point == 0 || at[point] != '.' || (point > 1 && *at == '0')) return nullptr;
  // Digits after the point move one byte forward, to the place of the point.
  const std::uint64_t whole = bytes_kept(others);
  std::uint64_t first = (begin & whole) | (values_at(at + 1) & ~whole), second = 0, third = 0;
  unsigned digits = 0;
  if (const std::uint64_t end = others_of(first); end != 0) {
    digits = bytes_before(end);
    if (digits == point) return nullptr;
    first &= bytes_kept(end);
  } else if (second = values_at(at + 9); others_of(second) != 0) {
    digits = 8 + bytes_before(others_of(second));
    second &= bytes_kept(others_of(second));
  } else {
    third = values_at(at + 17);
    digits = 16 + bytes_before(others_of(third) | (std::uint64_t{1} << 63));
    if (digits > kDigits) return nullptr;
    third &= bytes_kept(others_of(third));
  }
  const std::uint64_t last =
      (third & 0xffu) * 100 + ((third >> 8) & 0xffu) * 10 + ((third >> 16) & 0xffu);
  out.significand = value_of(first) * 100'000'000'000u + value_of(second) * 1000 + last;
  out.exponent = static_cast<std::int64_t>(point) - kDigits;
  return at + digits + 1;
}

/// Reads a number in any JSON form, with its sign. Returns its end, or null if the slow reader must
/// decide; `out` is then unspecified.
[[gnu::noinline]] inline const char* scan_any_number(const char* at, double& out) {
  constexpr unsigned kMostDigits = 19, kMostExponentDigits = 4;
  const bool negative = *at == '-';
  at += negative ? 1 : 0;
  const char* const begin = at;
  Decimal decimal;
  unsigned digits = append_digits(at, decimal.significand);
  if (digits == 0 || (digits > 1 && *begin == '0')) return nullptr;
  if (*at == '.') {
    const unsigned fraction = append_digits(++at, decimal.significand);
    if (fraction == 0) return nullptr;
    digits += fraction;
    decimal.exponent = -static_cast<std::int64_t>(fraction);
  }
  if (digits > kMostDigits && significant_digits(begin, digits) > kMostDigits) return nullptr;
  if (*at == 'e' || *at == 'E') {
    ++at;
    const bool down = *at == '-';
    at += *at == '-' || *at == '+' ? 1 : 0;
    std::uint64_t power = 0;
    const unsigned count = append_digits(at, power);
    if (count == 0 || count > kMostExponentDigits) return nullptr;
    decimal.exponent += down ? -static_cast<std::int64_t>(power) : static_cast<std::int64_t>(power);
  }
  return nearest_float64(decimal, negative, out) ? at : nullptr;
}

}  // namespace plain

/// Reads the number at `at` as the nearest float64 and moves `at` to the end of the number; what
/// follows the number is not checked. Returns false, with `at` unchanged and `out` unspecified, if
/// the slow reader must decide. Then the text is not a JSON number, has more than 19 significant
/// digits or 4 digits of exponent, overflows, or is too near the middle of two float64 numbers.
/// Precondition: kPlainPadding.
[[gnu::always_inline]] inline bool scan_plain_number(const char*& at, double& out) {
  const bool negative = *at == '-';
  plain::Decimal decimal;
  const char* behind = plain::scan_usual_decimal(at + (negative ? 1 : 0), decimal);
  // Nothing takes the address of `at`: it stays in a register.
  if (behind == nullptr || *behind == 'e' || *behind == 'E' ||
      !plain::nearest_of_19_digits(decimal, negative, out)) {
    behind = plain::scan_any_number(at, out);
    if (behind == nullptr) return false;
  }
  at = behind;
  return true;
}

}  // namespace sightline
