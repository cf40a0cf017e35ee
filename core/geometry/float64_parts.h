#pragma once
/// Float64Parts: mantissa, exponent and sign of a finite float64.

#include <bit>
#include <cstdint>

namespace sightline {

/// The parts of a float64: |value| = mantissa * 2^place. mantissa is below 2^53; it is 0 for +0 and
/// -0. negative is the sign bit, so it is true for -0.
struct Float64Parts {
  std::uint64_t mantissa = 0;
  int place = 0;
  bool negative = false;

  /// Precondition: value is finite.
  explicit Float64Parts(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const int biased = static_cast<int>((bits >> 52) & 0x7ff);
    negative = (bits >> 63) != 0;
    mantissa = bits & ((1ull << 52) - 1);
    if (biased != 0) mantissa |= 1ull << 52;
    place = (biased == 0 ? 1 : biased) - 1075;
  }
};

}  // namespace sightline

// Tests: tests/unit/geometry/dyadic_test.cpp
