#pragma once
/// Closed convex polyhedra, recognised exactly, and the exact penetration depth of two of them.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/base/deadline.h"
#include "core/geometry/convex/penetration.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// A convex polyhedron with its corners, faces and edges.
class ConvexBody {
 public:
  static constexpr std::size_t kMostTriangles = 128;

  /// Recognises the surface of a convex polyhedron: each edge belongs to two triangles, and no
  /// corner lies on one side of a triangle's plane while another lies on the other side. The
  /// orientation of triangles does not matter. Empty for other triangles, and for more than
  /// kMostTriangles. Precondition: triangles are finite and have an area.
  static std::optional<ConvexBody> of(std::span<const Triangle> triangles);

  const std::vector<Vec3d>& corners() const { return corners_; }
  ConvexParts parts() const { return {corners_, edges_, faces_}; }

 private:
  std::vector<Vec3d> corners_;                 ///< distinct
  std::vector<Segment> edges_;                 ///< also those inside of flat faces
  std::vector<std::array<Segment, 2>> faces_;  ///< of each triangle
};

/// The least length of a translation of one body after which the interiors have no common point; 0
/// if they have none already. Empty if the deadline passed. Cost: edges of a, times edges of b,
/// times corners.
std::optional<ExactDistance> penetration_depth(const ConvexBody& a, const ConvexBody& b,
                                               const Deadline& deadline);

}  // namespace sightline

// Tests: tests/unit/run/clash_test.cpp
