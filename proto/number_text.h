#pragma once
/// Numbers as text: byte for byte what std::to_chars writes, most of them in a third of its time.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace sightline {

/// What has to be writable where a number is written. Bytes behind its end are overwritten.
inline constexpr std::size_t kNumberRoom = 40;

/// The shortest text that reads back as the same float64, of several the nearest. Returns its end.
/// Precondition: `value` is finite.
char* write_float64(char* out, double value);

/// More than eight digits, in full.
char* write_long_integer(char* out, std::uint64_t value);

/// The eight digits of a number below 10^8 as bytes 0 to 9, the first one lowest.
inline std::uint64_t eight_digits(std::uint32_t value) {
  static_assert(std::endian::native == std::endian::little, "the first digit is the lowest byte");
  // x / 100 and x / 10 in lanes of 32 and 16 bits, exact for the four and two digits there.
  const std::uint64_t fours = value / 10000 | std::uint64_t{value % 10000} << 32;
  const std::uint64_t hundreds = (fours * 10486 >> 20) & 0x0000007f0000007fu;
  const std::uint64_t twos = hundreds | (fours - hundreds * 100) << 16;
  const std::uint64_t tens = (twos * 103 >> 10) & 0x000f000f000f000fu;
  return tens | (twos - tens * 10) << 8;
}

inline char* write_integer(char* out, std::uint64_t value) {
  if (value >= 100'000'000) return write_long_integer(out, value);
  const std::uint64_t digits = eight_digits(static_cast<std::uint32_t>(value));
  constexpr std::uint64_t kLastDigit = std::uint64_t{1} << 56, kTextOfZeros = 0x3030303030303030u;
  const unsigned zeros = static_cast<unsigned>(std::countr_zero(digits | kLastDigit)) / 8;
  const std::uint64_t text = (digits | kTextOfZeros) >> (8 * zeros);
  std::memcpy(out, &text, sizeof text);
  return out + (8 - zeros);
}

}  // namespace sightline
