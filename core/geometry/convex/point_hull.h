#pragma once
/// Closed triangle against the closed convex hull of points, exactly: touching counts.
///
/// Method   the faces of the hull are found by adding one point after the other. An edge of the
///          triangle meets the hull if it enters the last half-space before it leaves the first
///          one. If no edge does, the hull's section with the triangle's plane lies wholly inside
///          or outside of the triangle, and one point of the section tells which. A hull without a
///          volume is a polygon, a segment or a point, and is decided as that.
/// Filter   float64 with the error bound of [Shewchuk1997], then Dyadic numbers.
/// Proofs   docs/explanation/exactness-boxes.md.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/box3.h"
#include "core/geometry/convex/penetration.h"
#include "core/geometry/triangle.h"
#include "core/geometry/triangle_capsule.h"

namespace sightline {

/// Points of a query, whose convex hull is meant. They are finite; some or all may be equal. It
/// stores no points: the array that `points` views must outlive it.
struct PointHull {
  /// The most points that check_boxes (core/query/box_batch.h) accepts.
  static constexpr std::size_t kMostPoints = 256;

  std::span<const Vec3d> points;
};

/// The bounds of the points, exactly. Precondition: there is a point.
Box3d outer_bounds(const PointHull& hull);

/// The corners, edges and faces of a convex body; parts() views them.
struct BodyParts {
  std::vector<Vec3d> corners;
  std::vector<Segment> edges;
  std::vector<std::array<Segment, 2>> faces;

  ConvexParts parts() const { return {corners, edges, faces}; }
};

/// The convex hull of points, with its faces.
class ConvexHull {
 public:
  /// Finds the faces. Cost: the number of points times the number of faces; 32
  /// points take about 0.1 ms, 256 points 2 ms. Precondition: 1 to
  /// PointHull::kMostPoints points. Throws std::bad_alloc.
  explicit ConvexHull(const PointHull& hull);

  const Box3d& bounds() const { return bounds_; }
  /// True if triangle and hull have at least one point in common. False for a triangle that has
  /// exactly no area or a corner that is not finite. Cost: some 50 ns for each face, unless float64
  /// leaves something open.
  bool meets(const Triangle& triangle) const;
  /// True if p is in the hull. Precondition: p is finite.
  bool contains(const Vec3d& p) const;
  /// Its corners, its edges without those inside of flat faces, and its faces. Throws
  /// std::bad_alloc.
  BodyParts parts() const;

 private:
  using Face = std::array<std::uint32_t, 3>;
  struct Cut;

  void find_faces(const Face& first, std::uint32_t fourth);
  void find_polygon(const Face& first);
  static bool edge_meets(std::span<const Cut> cuts, const Triangle& triangle, std::size_t from);

  std::span<const Vec3d> points_;
  Box3d bounds_;
  /// The hull is the set of points p with volume_sign(v0, v1, v2, p) <= 0 for each of these planes,
  /// unless it is a segment or a point.
  std::vector<Triangle> planes_;
  std::vector<Face> faces_;         ///< of a hull with a volume: indices of points
  std::vector<Vec3d> polygon_;      ///< of a hull in a plane
  std::optional<Capsule> segment_;  ///< of radius 0: a segment or a point
};

/// The form of a shape that searches use: of points their hull, of other shapes the shape itself.
inline ConvexHull prepared(const PointHull& hull) { return ConvexHull(hull); }
template <class Shape>
const Shape& prepared(const Shape& shape) {
  return shape;
}

inline bool triangle_meets_box(const Triangle& triangle, const ConvexHull& hull) {
  return hull.meets(triangle);
}
inline bool is_within(const Vec3d& p, const ConvexHull& hull) { return hull.contains(p); }

}  // namespace sightline

// Tests: tests/unit/geometry/point_hull_test.cpp
