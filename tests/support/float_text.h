#pragma once
/// Float64 numbers as their bits: compared, and printed so that nothing is lost.

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <string>

namespace sightline::test {

/// Tells 0 from -0, and takes a NaN for itself.
inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// Hexadecimal: 0x1.8p+1.
inline std::string hex(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%a", value);
  return text.data();
}

}  // namespace sightline::test
