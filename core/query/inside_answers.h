#pragma once
/// Which points lie inside of what a scene's triangles enclose: the methods, and the answer.

#include <cstdint>

#include "core/base/column.h"

namespace sightline {

enum class InsideMethod {
  kParity,   ///< inside: a ray that leaves crosses an odd number of triangles
  kWinding,  ///< inside: it crosses not as many fronts as backs
};

/// Columns of n slots.
struct InsideAnswers {
  Column<std::uint8_t> inside;      ///< 1 or 0; of a point on a triangle 0
  Column<std::uint8_t> on_surface;  ///< 1: exactly on a triangle
  /// 1: rays in three directions agree. Around a closed mesh they always do (for the winding number
  /// if its triangles are oriented alike). Where they disagree the mesh has holes.
  Column<std::uint8_t> reliable;
  Column<std::int64_t> winding;  ///< backs less fronts, of the first direction; only for kWinding
  Column<double> distance;       ///< scene units, negative inside; only of signed_distances
  /// Open edges of the triangles that count (core/run/inside.h): without, every answer is right.
  std::uint64_t open_edges = 0;
};

}  // namespace sightline

// Tests: tests/unit/run/inside_test.cpp
