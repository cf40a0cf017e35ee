#pragma once
/// Sums and products of two float64 numbers without error, as the rounded result and what rounding
/// lost [Dekker1971], [Shewchuk1997].

#include <cmath>

namespace sightline {

/// high + low; high is the sum of both rounded to nearest.
struct TwoDouble {
  double high = 0;
  double low = 0;
};

/// a + b exactly, gradual underflow included. If high overflows, low is not a number.
inline TwoDouble two_sum(double a, double b) {
  const double high = a + b;
  const double part = high - a;
  return {high, (a - (high - part)) + (b - part)};
}

inline TwoDouble two_difference(double a, double b) { return two_sum(a, -b); }

/// a * b exactly if |high| is in [kProductMin, inf) or a factor is zero: then the last bit of the
/// product weighs at least 2^-1066. Below it low may be off by 2^-1074.
inline constexpr double kProductMin = 0x1p-960;
inline TwoDouble two_product(double a, double b) {
  const double high = a * b;
  return {high, std::fma(a, b, -high)};
}

}  // namespace sightline

// Tests: tests/unit/geometry/ray_box_test.cpp
