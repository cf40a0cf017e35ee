#pragma once
/// Pairs of points, to ask what stands between them.

#include <cstddef>

#include "core/base/column.h"
#include "core/geometry/vec3.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"

namespace sightline {

/// Pair i of "each" is from[i] and to[i]; of "all" pair i * to.size() + j is from[i] and to[j].
struct PointPairs {
  Column<Vec3d> from, to;
  BoxPairing pairing = BoxPairing::kAll;
  bool closed = false;  ///< whether what holds an end stands between, too

  std::size_t size() const {
    return pairing == BoxPairing::kAll ? from.size() * to.size() : from.size();
  }
  /// The ray that decides pair i: from `from` in the direction to - from, each coordinate rounded
  /// once, with t from 0 to 1, or, with open ends, from 2^-1074 to 1 - 2^-53. Of a point and
  /// itself: the point alone, or with open ends a ray that meets nothing.
  Ray ray(std::size_t i) const;
};

/// The place of a bad pair.
struct PairFault {
  std::size_t from = 0, to = 0;
};

/// Points are finite. Finds the first pair whose difference is not. Returns true if there is none.
/// Precondition for "each": as many from as to.
bool check_pairs(const PointPairs& pairs, PairFault& fault);

}  // namespace sightline

// Tests: tests/unit/run/visibility_test.cpp
