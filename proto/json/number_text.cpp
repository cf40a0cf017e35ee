#include "proto/json/number_text.h"

#include <fast_float/fast_float.h>

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

namespace sightline {
namespace {

constexpr auto kPowersOfFive = [] {
  std::array<std::uint64_t, 20> powers{1};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = powers[i - 1] * 5;
  return powers;
}();

void store_digits(char* at, std::uint64_t digits) {
  digits |= 0x3030303030303030u;
  std::memcpy(at, &digits, sizeof digits);
}

/// digits * 10^exponent
struct ShortestDecimal {
  std::uint64_t digits = 0;  ///< 16 or 17 of them, zeros at the end among them
  int exponent = 0;
};

/// Schubfach [Giulietti2020], without its table: at these exponents no product needs more than 128
/// bits, and nothing is rounded. For significand * 2^power with -62 <= power < 0 and 2^52 <
/// significand < 2^53.
ShortestDecimal shortest_decimal(std::uint64_t significand, int power) {
  // 10^exponent <= 2^power < 10^(exponent + 1): a number of that exponent always reads back, of the
  // next one at most one does.
  const int exponent = power * 78913 >> 18;  // log10(2) * 2^18
  const int shift = exponent - power + 1;
  // In these units the number is `twice`, 10^exponent is 2^shift, and what lies nearer than `reach`
  // reads back.
  const std::uint64_t five = kPowersOfFive[static_cast<std::size_t>(-exponent)];
  const fast_float::value128 twice = fast_float::full_multiplication(2 * significand, five);
  const std::uint64_t reach = five + (significand % 2 == 0 ? 1 : 0);
  const std::uint64_t below = twice.high << (64 - shift) | twice.low >> shift;
  const std::uint64_t rest = twice.low & ((std::uint64_t{1} << shift) - 1);
  const std::uint64_t down = (below % 10 << shift) + rest;
  const bool up_reads_back = (std::uint64_t{10} << shift) - down < reach;
  const std::uint64_t shorter = below - below % 10 + (up_reads_back ? 10 : 0);
  const std::uint64_t half = std::uint64_t{1} << (shift - 1);
  const std::uint64_t nearest = below + (rest + below % 2 > half ? 1 : 0);
  return {((down < reach) | up_reads_back) ? shorter : nearest, exponent};
}

char* write_other(char* out, double value) {
  return std::to_chars(out, out + kNumberRoom, value).ptr;
}

}  // namespace

char* write_json_number(char* out, double value) {
  constexpr std::string_view kMinusZero = "-0.0", kNull = "null";
  const bool is_minus_zero = value == 0 && std::signbit(value);
  if (std::isfinite(value) && !is_minus_zero) return write_float64(out, value);
  const std::string_view text = is_minus_zero ? kMinusZero : kNull;
  std::memcpy(out, text.data(), text.size());
  return out + text.size();
}

char* write_long_integer(char* out, std::uint64_t value) {
  return std::to_chars(out, out + kNumberRoom, value).ptr;
}

char* write_float64(char* out, double value) {
  // Those with a fraction whose text has no exponent, and small integers.
  constexpr double kLeast = 0.001, kMost = 0x1p52, kShortIntegers = 100000;
  constexpr int kFractionBits = 52;
  constexpr std::uint64_t kHiddenBit = std::uint64_t{1} << kFractionBits;
  const double size = std::fabs(value);
  if (!(size < kMost)) return write_other(out, value);
  const auto whole = static_cast<std::int64_t>(size);
  const bool is_whole = static_cast<double>(whole) == size;
  const auto bits = std::bit_cast<std::uint64_t>(size);
  const std::uint64_t fraction = bits & (kHiddenBit - 1);
  // What comes before a power of two is nearer than what comes behind it.
  const bool is_usual = is_whole ? size < kShortIntegers : size >= kLeast && fraction != 0;
  if (!is_usual) return write_other(out, value);
  *out = '-';
  out += std::signbit(value) ? 1 : 0;
  if (is_whole) return write_integer(out, static_cast<std::uint64_t>(whole));
  const ShortestDecimal decimal = shortest_decimal(
      fraction | kHiddenBit, static_cast<int>(bits >> kFractionBits) - 1023 - kFractionBits);

  constexpr std::uint64_t kEightDigits = 100'000'000;
  constexpr int kFewest = 16;
  const std::uint64_t front = decimal.digits / kEightDigits;
  const std::uint64_t middle = eight_digits(static_cast<std::uint32_t>(front % kEightDigits));
  const std::uint64_t last =
      eight_digits(static_cast<std::uint32_t>(decimal.digits % kEightDigits));
  const int more = front >= kEightDigits ? 1 : 0;
  std::array<char, kNumberRoom> text{};
  text[7] = static_cast<char>('0' + front / kEightDigits);
  store_digits(text.data() + 8, middle);
  store_digits(text.data() + 16, last);
  const char* const digits = text.data() + 8 - more;
  const int count = kFewest + more, point = count + decimal.exponent;
  // More is copied than there is: how much would be a branch that nobody can foretell.
  if (point > 0) {
    std::memcpy(out, digits, kFewest);
    std::memcpy(out + point + 1, digits + point, kFewest);
    out[point] = '.';
    out += count + 1;
  } else {
    std::memcpy(out, "0.000000", 8);  // NOLINT(bugprone-not-null-terminated-result): text follows
    std::memcpy(out + 2 - point, digits, kFewest + 1);
    out += 2 - point + count;
  }
  if (last != 0) return out - std::countl_zero(last) / 8;
  while (out[-1] == '0') --out;
  return out;
}

}  // namespace sightline
