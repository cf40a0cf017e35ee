#pragma once
/// One ray against one triangle in integers: the sentences of the contract, word by word.

#include <array>
#include <optional>

#include "core/query/ray_batch.h"
#include "tests/oracle/rational.h"

namespace sightline::oracle {

/// The three float64 corners of a triangle in the world.
struct Triangle {
  Vec3d v0, v1, v2;
};

/// False when a coordinate is infinite or NaN: such a triangle is dropped.
bool is_finite(const Triangle& triangle);
/// True when the corners lie on one line, exactly. Precondition: finite.
bool has_no_area(const Triangle& triangle);

/// The least real t in [ray.tmin, ray.tmax] with ray.origin + t * ray.direction on the closed
/// triangle, or nothing. A ray in the plane of the triangle meets it where it enters (or at tmin
/// when it starts on it). The empty answer also for a triangle without area.
/// Preconditions: the ray passes check_rays, the triangle is finite.
std::optional<Rational> least_t(const Ray& ray, const Triangle& triangle);

/// Whether the line, moved by (e, e^2, e^3) for every small enough e > 0, passes through the inside
/// of the triangle: the rule by which a crossing of a shared edge or corner counts once (Crossings
/// in core/query/hit_batch.h). Preconditions as above.
bool crosses_when_moved(const Ray& ray, const Triangle& triangle);

/// What else an answer says of a hit, exactly.
struct ExactDetail {
  std::array<mpq_class, 3> position;
  std::array<mpq_class, 3> normal;  ///< (v1 - v0) x (v2 - v0), not unit
  mpq_class u, v;                   ///< weights of v1 and v2
  bool front = false;               ///< direction . normal < 0
};
/// Precondition: t came from least_t of the same ray and triangle.
ExactDetail exact_detail(const Ray& ray, const Triangle& triangle, const Rational& t);

}  // namespace sightline::oracle
