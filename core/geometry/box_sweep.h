#pragma once
/// A box swept along a line, against a triangle, exactly.
///
/// Method   A box and a triangle have thirteen separating axes (triangle_box.h). Along each of them
///          the projections of the moving box and the triangle overlap during one interval of t,
///          whose ends are ratios of polynomials of degree three. The box meets the triangle while
///          the projections overlap on all axes. An oriented box is an axis-aligned one in the
///          coordinates s_k = a_k . (p - c), where the degrees are six.
/// Proofs   docs/explanation/exactness-sweeps.md.

#include <array>
#include <cstddef>
#include <optional>

#include "core/geometry/exact_hit.h"
#include "core/geometry/sweep_path.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// A box whose centre moves along a SweepPath; it does not turn.
struct SweptBox {
  /// Half of the length along each axis, in scene units: finite and not negative. 0 is allowed.
  Vec3d half;
  /// The axes of an OrientedBox (box_oriented.h), not in one plane; empty: the box is axis-aligned.
  std::optional<std::array<Vec3d, 3>> axes{};
};

/// The first contact of a swept box with a triangle, as an exact number t. first() finds it,
/// compare() orders contacts of several triangles, rounded(), position() and normal() give its
/// numbers.
class BoxContact {
 public:
  /// The contact with the least t in [tmin, tmax] of the path; touching is a contact. Empty if box
  /// and triangle never meet within these limits, if the triangle has exactly no area, or if a
  /// corner of the triangle is not finite. Preconditions: those of SweepPath and SweptBox.
  static std::optional<BoxContact> first(const SweepPath& path, const SweptBox& box,
                                         const Triangle& triangle);

  /// t rounded once to float64.
  double rounded() const { return t_.rounded(); }
  /// Sign of a.t - b.t, exactly: -1, 0 or 1.
  friend int compare(const BoxContact& a, const BoxContact& b) { return compare(a.t_, b.t_); }
  /// The contact point at t: of all points that box and triangle share, the point with the least x,
  /// then y, then z. Each coordinate is rounded once. Precondition: the arguments are those given
  /// to first(). Throws std::bad_alloc.
  Vec3d position(const SweepPath& path, const SweptBox& box, const Triangle& triangle) const;

  /// The unit normal of a plane that separates box and triangle at t, on the box's side, each
  /// component rounded once. It is the first of these that separates them: the normals of the box,
  /// that of the triangle, the cross products of their edges. Empty if the box met the triangle
  /// before tmin. Precondition: the arguments are those given to first().
  std::optional<Vec3d> normal(const SweepPath& path, const SweptBox& box,
                              const Triangle& triangle) const;

 private:
  static constexpr std::size_t kNoAxis = 13;

  ExactT t_;
  std::size_t axis_ = kNoAxis;  ///< the separating axis along which they meet last
};

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
