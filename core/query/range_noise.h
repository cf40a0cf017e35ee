#pragma once
/// Errors of measured distances: the same on every machine, independent of threads and batches.

#include "core/base/split_mix.h"
#include "core/query/ray_generators.h"

namespace sightline {

/// The errors of one ray of a generator, drawn from splitmix64 with a stream for each ray. The first
/// number of [0, 1) decides whether the ray is dropped. Each return, from the first on, uses twelve
/// more: their sum less 6 is its error in units of sigma, with the variance 1 and at most 6.
class RangeErrors {
 public:
  /// ray  number of the ray in its generator
  RangeErrors(const RangeNoise& noise, std::uint64_t ray);

  bool is_dropped() const { return is_dropped_; }
  /// The measured t of the next return at `t`: t plus the error, at least `tmin`.
  double measured(double t, double tmin);

 private:
  SplitMix numbers_;
  double sigma_;
  bool is_dropped_;
};

}  // namespace sightline

// Tests: tests/integration/sensors_test.py
