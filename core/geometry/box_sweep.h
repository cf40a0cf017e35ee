#pragma once
/// An axis-aligned box swept along a line, against a triangle, exactly.
///
/// Method   Box and triangle have thirteen separating axes (triangle_box.h). Along each of them
///          their projections overlap during one interval of t, whose ends are ratios of
///          polynomials of degree three. They meet while the projections overlap on all axes.
/// Proofs   docs/explanation/exactness-sweeps.md.

#include <optional>

#include "core/geometry/exact_hit.h"
#include "core/geometry/sweep_path.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The closed box of these half extents around the centre; finite, not negative.
struct SweptBox {
  Vec3d half;
};

/// The first contact of a swept box with a triangle.
class BoxContact {
 public:
  /// Empty if they never meet within the limits, and for triangles that have exactly no area or a
  /// corner that is not finite.
  static std::optional<BoxContact> first(const SweepPath& path, const SweptBox& box,
                                         const Triangle& triangle);

  /// t, rounded once.
  double rounded() const { return t_.rounded(); }
  friend int compare(const BoxContact& a, const BoxContact& b) { return compare(a.t_, b.t_); }
  /// The contact point at t: of all points that both shapes share, the point with the least x, then
  /// y, then z. Each coordinate is rounded once. Takes the arguments of first. Throws
  /// std::bad_alloc.
  Vec3d position(const SweepPath& path, const SweptBox& box, const Triangle& triangle) const;

 private:
  ExactT t_;
};

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
