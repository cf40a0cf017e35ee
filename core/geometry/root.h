#pragma once
/// Numbers with square roots in them, known by comparisons.

#include "core/geometry/dyadic.h"

namespace sightline {

/// Sign of a + b sqrt(c). Precondition: c is not negative.
int sign_with_root(const Dyadic& a, const Dyadic& b, const Dyadic& c);

/// (a + b sqrt(c)) / divisor. Preconditions: c is not negative, the divisor is positive.
struct RootNumber {
  Dyadic a, b, c, divisor{1.0};

  /// Sign of this number minus x.
  int compare_to(const Dyadic& x) const { return sign_with_root(a - x * divisor, b, c); }
  /// Rounded once to the nearest float64, ties to even; beyond the largest number an infinity.
  double rounded() const;
};

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
