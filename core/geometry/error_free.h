#pragma once
/// Error-free transformations: sums and products of two float64 numbers as the rounded result and
/// its rounding error [Dekker1971], [Shewchuk1997]. Precondition of all: the arguments are finite.

#include <cmath>

namespace sightline {

/// The exact number high + low, where high is that number rounded to the nearest float64.
struct TwoDouble {
  double high = 0;
  double low = 0;
};

/// a + b exactly, with gradual underflow. If high overflows, low is NaN.
inline TwoDouble two_sum(double a, double b) {
  const double high = a + b;
  const double part = high - a;
  return {high, (a - (high - part)) + (b - part)};
}

/// a - b, with the properties of two_sum.
inline TwoDouble two_difference(double a, double b) { return two_sum(a, -b); }

/// The least |high| for which two_product is exact: the last bit of the product then weighs at
/// least 2^-1066.
inline constexpr double kProductMin = 0x1p-960;
/// a * b. The result is exact if a factor is zero, or if |high| is finite and at least kProductMin.
/// For smaller products low may be off by 2^-1074.
inline TwoDouble two_product(double a, double b) {
  const double high = a * b;
  return {high, std::fma(a, b, -high)};
}

}  // namespace sightline

// Tests: tests/unit/geometry/ray_box_test.cpp
