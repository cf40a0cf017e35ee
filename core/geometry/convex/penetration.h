#pragma once
/// How deep two convex bodies overlap, and along which direction they separate first, exactly.
///
/// Method   the shortest translation that separates them is the least overlap along some direction.
///          These directions are the normals of the faces of the Minkowski difference: normals of
///          faces of either body, and cross products of two edges.
/// Filter   float64 intervals exclude most of these directions, Dyadic numbers compare the others.
/// Proofs   docs/explanation/exactness-boxes.md.

#include <array>
#include <optional>
#include <span>

#include "core/base/deadline.h"
#include "core/geometry/dyadic_vector.h"
#include "core/geometry/point_triangle.h"

namespace sightline {

using Segment = std::array<Vec3d, 2>;

/// The corners of a convex body, its edges (as segments that are parallel to them), and its faces
/// (as two segments that span each). A segment, a point or a triangle is a body too. The spans view
/// memory of the caller; all numbers are finite, and segments and faces are not degenerate.
struct ConvexParts {
  std::span<const Vec3d> corners;
  std::span<const Segment> edges;
  std::span<const std::array<Segment, 2>> faces;
};

/// The shortest translation of a body `a` after which it and a body `b` have no common point but on
/// their border.
struct Penetration {
  ExactDistance depth;
  /// The direction of the translation, of any length. Zero if the bodies had no common point.
  DyadicVector direction;
};

/// The least of several translations. At equal depth a lesser rank comes first, then the larger x
/// of the unit direction, then its larger y, then its larger z.
class LeastPenetration {
 public:
  /// Offers the translation along n, which is not zero, by `overlap` / (|n| * weight). The overlap
  /// is not negative; the weight, which is positive, is the same in all calls.
  void offer(const DyadicVector& n, const Dyadic& overlap, int rank);

  /// The best offer, without the weight; empty if there was none.
  const std::optional<Penetration>& best() const { return best_; }

 private:
  std::optional<Penetration> best_;
  int rank_ = 0;
};

/// The least translation. Directions along normals of faces of `b` have rank 0 on the side from
/// which their segments run counter-clockwise, and rank 1 on the other; all others have rank 2.
/// Empty if the deadline passed. Cost: edges of a, times edges of b, times corners.
std::optional<Penetration> penetration(const ConvexParts& a, const ConvexParts& b,
                                       const Deadline& deadline);

}  // namespace sightline

// Tests: tests/unit/geometry/shape_contact_test.cpp
