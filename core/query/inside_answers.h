#pragma once
/// The question which points lie inside of closed surfaces: its methods and its answer.

#include <cstdint>

#include "core/base/column.h"

namespace sightline {

/// How "inside" is decided, with a ray from the point to infinity. Crossings are counted by
/// Crossings::kOnce (hit_batch.h).
enum class InsideMethod {
  kParity,      ///< inside: the ray crosses an odd number of triangles
  kWinding,     ///< inside: the ray crosses unequal numbers of front and back sides
  kSolidAngle,  ///< inside: the generalized winding number is above 1/2 or below -1/2
};

/// The answers for n points, as columns of n elements; element i answers point i.
struct InsideAnswers {
  Column<std::uint8_t> inside;      ///< 1: inside, 0: outside or on a triangle
  Column<std::uint8_t> on_surface;  ///< 1 for a point exactly on a triangle, else 0
  /// 1 if rays in three directions give equal results, or if the point is on a triangle. That is
  /// always so for closed meshes (for kWinding, if their triangles are also oriented consistently).
  /// If the results differ, a mesh has holes. For kSolidAngle: 1 if `generalized` is further from
  /// 1/2 and -1/2 than its error.
  Column<std::uint8_t> reliable;
  /// Back sides minus front sides that the first of three rays crosses; 0 on a triangle. Set for
  /// kWinding, else empty.
  Column<std::int64_t> winding;
  /// For kSolidAngle, else empty: the generalized winding number (core/run/solid_angle.h), and a
  /// bound of its absolute error. NaN and 0 on a triangle.
  Column<double> generalized, error;
  /// To the nearest triangle, in scene units, negative inside. Set only by
  /// Engine::signed_distances.
  Column<double> distance;
  /// The number of open edges of the triangles that count (core/run/inside.h). If it is 0, every
  /// element of `inside` is right.
  std::uint64_t open_edges = 0;
};

}  // namespace sightline

// Tests: tests/unit/run/inside_test.cpp
