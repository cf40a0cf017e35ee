#pragma once
/// Directed rounding from float64 to float32, and to neighbouring float64 numbers, without changing
/// the rounding mode. The unit roundoff.

#include <cmath>
#include <limits>

namespace sightline {

inline constexpr float kInfF = std::numeric_limits<float>::infinity();
inline constexpr double kInfD = std::numeric_limits<double>::infinity();

/// Unit roundoff of float64: the largest relative error of one rounding.
inline constexpr double kU = 0x1p-53;

/// x rounded to the nearest float32. The value passes through memory because g++ 12.2 -O2 was seen
/// to drop a double -> float -> double rounding inside a vectorised loop.
inline float to_float(double x) {
  volatile float rounded = static_cast<float>(x);
  return rounded;
}

/// The largest float32 that is not above x; NaN stays NaN.
inline float float_below(double x) {
  const float f = to_float(x);
  return static_cast<double>(f) > x ? std::nextafterf(f, -kInfF) : f;
}

/// The smallest float32 that is not below x; NaN stays NaN.
inline float float_above(double x) {
  const float f = to_float(x);
  return static_cast<double>(f) < x ? std::nextafterf(f, kInfF) : f;
}

/// The neighbouring float64 numbers above and below x.
inline double next_above(double x) { return std::nextafter(x, kInfD); }
inline double next_below(double x) { return std::nextafter(x, -kInfD); }

}  // namespace sightline

// Tests: tests/unit/geometry/point_triangle_test.cpp
