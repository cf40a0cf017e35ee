#pragma once
/// Arithmetic of float64 vectors with ordinary rounding, for rays that are generated and for views.
/// Sums go left to right, without FMA.

#include "core/geometry/vec3.h"

namespace sightline {

inline double dot(const Vec3d& a, const Vec3d& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
inline Vec3d minus(const Vec3d& a, const Vec3d& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
