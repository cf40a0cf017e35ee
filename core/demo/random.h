#pragma once
/// Small deterministic generators: a seed gives the same numbers on every machine. They use only
/// integer arithmetic and float64 + - * /, which are correctly rounded everywhere, and no libm.

#include <cstdint>

#include "core/base/split_mix.h"
#include "core/geometry/affine.h"

namespace sightline::demo {

/// The pseudo-random numbers of a seed. Not thread-safe.
class Random : public SplitMix {
 public:
  explicit Random(std::uint64_t seed) : SplitMix(scramble(seed)) {}

  /// Uniform in [low, high).
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// In [low, high), about equally likely in each halving of the range: high/2 to high, high/4 to
  /// high/2, and so on down to `low`. Precondition: 0 < low < high.
  double spread(double low, double high);
  /// Uniform in 0, 1, ... count - 1.
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>((bits() >> 32) * count >> 32);
  }
};

/// Fractal value noise at (x, z), in (-1, 1): the sum of `octaves` layers. The first has cells of
/// side `cell` and the weight 1/2; each next one has half the side and half the weight.
double fractal_noise(double x, double z, double cell, int octaves, std::uint64_t seed);

/// A random rotation about +y. Sine and cosine are computed from a random tangent of the
/// half-angle.
Affine random_turn(Random& random);
/// A random rotation about a random axis, from an unnormalised quaternion.
Affine random_rotation(Random& random);
/// The matrix of a translation by (x, y, z).
Affine translation(double x, double y, double z);
/// The matrix of a scale by x, y and z along the axes.
Affine scaling(double x, double y, double z);

}  // namespace sightline::demo

// Tests: tests/unit/demo/scenes_test.cpp
