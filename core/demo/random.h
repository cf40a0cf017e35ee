#pragma once
/// Small deterministic generators, so that a seed gives the same bytes on every machine: only
/// integer arithmetic, and float64 + - * / (correctly rounded everywhere). No libm.

#include <cstdint>

#include "core/geometry/affine.h"

namespace sightline::demo {

/// One step of [Steele2014]: a bijective scrambling of 64 bits.
constexpr std::uint64_t scramble(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// The SplitMix64 sequence of a seed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(scramble(seed)) {}

  std::uint64_t bits() {
    const std::uint64_t value = scramble(state_);
    state_ += 0x9e3779b97f4a7c15u;
    return value;
  }
  /// Uniform in [0, 1), a multiple of 2^-53.
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// In [low, high), every halving of the range about equally likely: sizes from pebbles to towers.
  double spread(double low, double high);
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>((bits() >> 32) * count >> 32);
  }

 private:
  std::uint64_t state_;
};

/// Value noise with `octaves` halvings of its cell, in (-1, 1); `cell` is the largest cell's side.
double fractal_noise(double x, double z, double cell, int octaves, std::uint64_t seed);

/// A rotation about +y. Sine and cosine come from the half-angle's tangent, which is drawn.
Affine random_turn(Random& random);
/// A rotation about a random axis, from an unnormalised quaternion.
Affine random_rotation(Random& random);
Affine translation(double x, double y, double z);
Affine scaling(double x, double y, double z);

}  // namespace sightline::demo
