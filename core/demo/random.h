#pragma once
/// Small deterministic generators, so that a seed gives the same bytes on every machine: only
/// integer arithmetic, and float64 + - * / (correctly rounded everywhere). No libm.

#include <cstdint>

#include "core/base/split_mix.h"
#include "core/geometry/affine.h"

namespace sightline::demo {

/// The numbers of a seed. Seeds that follow one another give sequences that do not overlap.
class Random : public SplitMix {
 public:
  explicit Random(std::uint64_t seed) : SplitMix(scramble(seed)) {}

  double between(double low, double high) { return low + (high - low) * unit(); }
  /// In [low, high), every halving of the range about equally likely: sizes from pebbles to towers.
  double spread(double low, double high);
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>((bits() >> 32) * count >> 32);
  }
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

// Tests: tests/unit/demo/scenes_test.cpp
