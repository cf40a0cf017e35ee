#pragma once
/// Triangle: three float64 corners. The triangle is closed: its edges and corners belong to it.

#include <cmath>

#include "core/geometry/vec3.h"

namespace sightline {

/// A triangle; its front is the side from which v0, v1, v2 run counter-clockwise.
struct Triangle {
  Vec3d v0, v1, v2;
};

/// True if every coordinate is finite.
inline bool is_finite(const Vec3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}
inline bool is_finite(const Vec3d& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}
inline bool is_finite(const Triangle& t) {
  return is_finite(t.v0) && is_finite(t.v1) && is_finite(t.v2);
}

}  // namespace sightline

// Tests: tests/unit/geometry/exact_hit_test.cpp
