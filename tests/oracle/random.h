#pragma once
/// Seeded numbers for tests: the same sequence on every machine and standard library, which
/// std::uniform_real_distribution does not promise.

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/geometry/vec3.h"

namespace sightline::oracle {

/// splitmix64 [Steele2014].
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  /// In [0, 1), a multiple of 2^-53.
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// In [0, count). Precondition: count > 0.
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(bits() % count); }
  int integer(int low, int high) {
    return low + static_cast<int>(index(static_cast<std::size_t>(high - low) + 1));
  }
  bool chance(double probability) { return unit() < probability; }

  Vec3d point(double low, double high) {
    const double x = between(low, high), y = between(low, high);
    return {x, y, between(low, high)};
  }
  /// Uniform on the unit sphere, up to rounding.
  Vec3d direction() {
    const double z = between(-1, 1);
    const double angle = between(0, 6.283185307179586);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }
  /// Any finite float64 or float32 bit pattern, uniform over patterns.
  double any_double() {
    for (;;) {
      const double value = std::bit_cast<double>(bits());
      if (std::isfinite(value)) return value;
    }
  }
  float any_float() {
    for (;;) {
      const float value = std::bit_cast<float>(static_cast<std::uint32_t>(bits() >> 32));
      if (std::isfinite(value)) return value;
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace sightline::oracle
