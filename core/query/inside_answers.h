#pragma once
/// The question which points lie inside of closed surfaces: its methods and its answer.

#include <cstdint>

#include "core/base/column.h"

namespace sightline {

/// How "inside" is decided, with a ray from the point to infinity.
enum class InsideMethod {
  kParity,   ///< inside: the ray crosses an odd number of triangles
  kWinding,  ///< inside: the ray crosses unequal numbers of front and back sides
};

/// The answers for n points, as columns of n slots.
struct InsideAnswers {
  Column<std::uint8_t> inside;      ///< 1 or 0; 0 for a point on a triangle
  Column<std::uint8_t> on_surface;  ///< 1 for a point exactly on a triangle, else 0
  /// 1 if rays in three directions give the same result. That is always so for closed meshes (for
  /// kWinding, if their triangles are also oriented consistently). If the results differ, a mesh
  /// has holes.
  Column<std::uint8_t> reliable;
  /// back sides minus front sides along the first direction; set only for kWinding
  Column<std::int64_t> winding;
  Column<double> distance;  ///< scene units, negative inside; set only by signed_distances
  /// The number of open edges of the triangles that count (core/run/inside.h). If it is 0, every
  /// answer is right.
  std::uint64_t open_edges = 0;
};

}  // namespace sightline

// Tests: tests/unit/run/inside_test.cpp
