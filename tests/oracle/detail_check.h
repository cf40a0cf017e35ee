#pragma once
/// Holds a HitDetail against the promise: position within one ulp per coordinate of the exact
/// point, barycentrics within 2^-50, unit normal within 1e-15 (Euclidean distance), side exact.

#include "core/query/hit_batch.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

struct DetailErrors {
  double position_ulp = 0;  ///< worst coordinate, in ulp of the exact coordinate's binade
  double barycentric = 0;   ///< worse of u and v, absolute
  double normal = 0;        ///< distance from the exact unit normal
  bool front_wrong = false;

  /// Decided in exact arithmetic; the numbers above are for people.
  bool position_kept = true, barycentric_kept = true, normal_kept = true;
  bool kept() const { return position_kept && barycentric_kept && normal_kept && !front_wrong; }
};

/// Precondition: t came from least_t of the same ray and triangle.
DetailErrors check_detail(const Ray& ray, const Triangle& triangle, const Rational& t,
                          const HitDetail& detail);

}  // namespace sightline::oracle
