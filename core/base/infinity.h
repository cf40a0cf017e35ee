#pragma once
/// kInf: +infinity, the upper limit of a ray without an end.

#include <limits>

namespace sightline {

/// +infinity of float64.
inline constexpr double kInf = std::numeric_limits<double>::infinity();

}  // namespace sightline

// Tests: tests/unit/geometry/exact_hit_test.cpp
