#pragma once
/// Rounding to float32 that stays a rounding.

namespace sightline::oracle {

/// The float32 nearest to value, as a float64. g++ 12.2 -O2 dropped the rounding of
/// double(float(x)) in vectorised loops; it may not drop a volatile.
inline double to_float32(double value) {
  volatile float narrow = static_cast<float>(value);
  return static_cast<double>(narrow);
}

}  // namespace sightline::oracle
