#pragma once
/// Vectors of float64 numbers with ordinary rounding, in which the filters are written. Components
/// are summed left to right, without FMA.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/vec3.h"

namespace sightline::float64 {

/// The components x, y, z.
using Numbers = std::array<double, 3>;

inline Numbers minus(const Vec3d& a, const Vec3d& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Numbers minus(const Numbers& a, const Numbers& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline double dot(const Numbers& a, const Numbers& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Numbers cross(const Numbers& a, const Numbers& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// The largest magnitude of a component.
inline double largest(const Numbers& a) {
  return std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])});
}

/// Finds the point of a triangle that is nearest to the origin, approximately; returns its
/// barycentric weights of the second and third corner. Whatever rounding does, the weights belong
/// to some point of the triangle: both are at least 0, and their sum is at most 1. `corner` has the
/// corners relative to the query point. `ab` and `ac` are the edges from the first corner to the
/// second and third. Method: regions of the triangle [Ericson2005].
std::array<double, 2> near_weights(const std::array<Numbers, 3>& corner, const Numbers& ab,
                                   const Numbers& ac);

}  // namespace sightline::float64

// Tests: tests/unit/geometry/point_triangle_test.cpp
