#pragma once
/// The judge of sweeps, in rational arithmetic.

#include <array>
#include <optional>

#include "core/query/ray_batch.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

/// The least t within the ray's finite limits at which the closed box of these half extents and
/// axes (core/geometry/box_oriented.h) around origin + t * direction has a point of the triangle:
/// the least corner of a polyhedron in t and two weights, found by trying every three of its planes.
std::optional<mpq_class> box_contact(const Ray& ray, const Vec3d& half,
                                     const std::array<Vec3d, 3>& axes, const Triangle& triangle);
std::optional<mpq_class> box_contact(const Ray& ray, const Vec3d& half, const Triangle& triangle);

/// Whether a capsule of that radius meets the triangle while its first end goes from t = `from` to
/// `to` on the ray; the second end is at `end` for t = 0.
bool capsule_meets(const Ray& ray, const Vec3d& end, const mpq_class& from, const mpq_class& to,
                   const mpq_class& radius, const Triangle& triangle);
/// Whether a ball of that radius meets the triangle while its centre goes from t = `from` to `to`.
bool sphere_meets(const Ray& ray, const mpq_class& from, const mpq_class& to,
                  const mpq_class& radius, const Triangle& triangle);

}  // namespace sightline::oracle
