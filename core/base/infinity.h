#pragma once
/// Where a ray that has no end ends.

#include <limits>

namespace sightline {

inline constexpr double kInf = std::numeric_limits<double>::infinity();

}  // namespace sightline
