#pragma once
/// Exact numbers of the form (a + b sqrt(c)) / divisor, which are compared without computing the
/// root.

#include "core/geometry/dyadic.h"

namespace sightline {

/// Sign of a + b sqrt(c), exactly: -1, 0 or 1. Precondition: c is not negative.
int sign_with_root(const Dyadic& a, const Dyadic& b, const Dyadic& c);

/// The number (a + b sqrt(c)) / divisor. Preconditions: c is not negative, the divisor is positive.
struct RootNumber {
  Dyadic a, b, c, divisor{1.0};

  /// Sign of this number minus x, exactly.
  int compare_to(const Dyadic& x) const { return sign_with_root(a - x * divisor, b, c); }
  /// The number rounded once to the nearest float64, ties to even; infinite beyond the largest
  /// float64.
  double rounded() const;
};

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
