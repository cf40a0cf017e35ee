#pragma once
/// DyadicVector: vectors of Dyadic numbers, in which the exact predicates are written. Every
/// function here is exact.

#include <array>
#include <cstddef>

#include "core/geometry/dyadic.h"
#include "core/geometry/vec3.h"

namespace sightline {

/// The components x, y, z.
using DyadicVector = std::array<Dyadic, 3>;

/// Converts a float64 vector, exactly. Precondition: v is finite.
inline DyadicVector exact_vector(const Vec3d& v) { return {Dyadic(v.x), Dyadic(v.y), Dyadic(v.z)}; }

/// a - b. Precondition: both finite.
inline DyadicVector difference(const Vec3d& a, const Vec3d& b) {
  return {Dyadic(a.x) - Dyadic(b.x), Dyadic(a.y) - Dyadic(b.y), Dyadic(a.z) - Dyadic(b.z)};
}

/// Component k (0, 1 or 2) of the cross product a x b.
inline Dyadic cross_component(const DyadicVector& a, const DyadicVector& b, std::size_t k) {
  const std::size_t i = (k + 1) % 3;
  const std::size_t j = (k + 2) % 3;
  return a[i] * b[j] - a[j] * b[i];
}

inline DyadicVector cross(const DyadicVector& a, const DyadicVector& b) {
  return {cross_component(a, b, 0), cross_component(a, b, 1), cross_component(a, b, 2)};
}

/// The dot product of a and b. Precondition: both finite.
inline Dyadic exact_dot(const Vec3d& a, const Vec3d& b) {
  return Dyadic(a.x) * Dyadic(b.x) + Dyadic(a.y) * Dyadic(b.y) + Dyadic(a.z) * Dyadic(b.z);
}
inline Dyadic dot(const DyadicVector& a, const DyadicVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace sightline

// Tests: tests/unit/geometry/exact_hit_test.cpp
