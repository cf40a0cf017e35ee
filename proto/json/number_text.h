#pragma once
/// Writes numbers as text. The bytes are those of std::to_chars; most numbers take a third of its
/// time.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace sightline {

/// The length of the longest number: "-1.7976931348623157e+308".
inline constexpr std::size_t kLongestNumber = 24;
/// The number of bytes that must be writable where a number is written: at `out` of each function.
/// Bytes after the number are overwritten.
inline constexpr std::size_t kNumberRoom = 40;

/// Writes the shortest text from which the same float64 is read; of several, the nearest. Returns
/// its end. Precondition: `value` is finite.
char* write_float64(char* out, double value);

/// Writes a number for JSON, as write_float64 does, and returns its end. -0.0 becomes "-0.0",
/// because many readers take "-0" for an integer and lose the sign. NaN and infinity, which JSON
/// does not have, become "null".
char* write_json_number(char* out, double value);

/// The largest integer that short_integer writes.
inline constexpr std::uint32_t kLongestShort = 99'999'999;
/// Writes an integer above kLongestShort, and returns its end.
char* write_long_integer(char* out, std::uint64_t value);

/// The eight digits of a number as bytes 0 to 9, the first digit in the lowest byte. Precondition:
/// value < 10^8.
inline std::uint64_t eight_digits(std::uint32_t value) {
  static_assert(std::endian::native == std::endian::little, "the first digit is the lowest byte");
  // Divisions by 100 and by 10 in lanes of 32 and 16 bits, which are exact for numbers of four and
  // two digits.
  const std::uint64_t fours = value / 10000 | std::uint64_t{value % 10000} << 32;
  const std::uint64_t hundreds = (fours * 10486 >> 20) & 0x0000007f0000007fu;
  const std::uint64_t twos = hundreds | (fours - hundreds * 100) << 16;
  const std::uint64_t tens = (twos * 103 >> 10) & 0x000f000f000f000fu;
  return tens | (twos - tens * 10) << 8;
}

/// At most eight characters, the first in the lowest byte, followed by zeros.
struct ShortText {
  std::uint64_t bytes = 0;
  unsigned size = 0;

  /// Writes eight bytes to `out`, and returns the end of the characters.
  char* write(char* out) const {
    std::memcpy(out, &bytes, sizeof bytes);
    return out + size;
  }
};

/// The digits of an integer as text. Precondition: value < 10^8.
inline ShortText short_integer(std::uint32_t value) {
  constexpr std::uint64_t kLastDigit = std::uint64_t{1} << 56, kTextOfZeros = 0x3030303030303030u;
  const std::uint64_t digits = eight_digits(value);
  const unsigned zeros = static_cast<unsigned>(std::countr_zero(digits | kLastDigit)) / 8;
  return {(digits | kTextOfZeros) >> (8 * zeros), 8 - zeros};
}

/// Writes an integer, and returns its end.
inline char* write_integer(char* out, std::uint64_t value) {
  if (value > kLongestShort) return write_long_integer(out, value);
  return short_integer(static_cast<std::uint32_t>(value)).write(out);
}

/// Writes an integer, or `instead` if `value` equals `nothing`; returns the end. The choice needs
/// no branch.
inline char* write_integer_or(char* out, std::uint32_t value, std::uint32_t nothing,
                              ShortText instead) {
  const bool is_nothing = value == nothing;
  if (value > kLongestShort && !is_nothing) return write_long_integer(out, value);
  const ShortText text = short_integer(is_nothing ? 0 : value);
  return ShortText{is_nothing ? instead.bytes : text.bytes, is_nothing ? instead.size : text.size}
      .write(out);
}

}  // namespace sightline
