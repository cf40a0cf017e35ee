#pragma once
/// PointPairs: pairs of points, for the question whether something blocks the line between them.

#include <cstddef>

#include "core/base/column.h"
#include "core/geometry/vec3.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"

namespace sightline {

/// Pairs of points. With kEach, pair i is from[i] and to[i], and the columns have equal sizes. With
/// kAll, pair i * to.size() + j is from[i] and to[j].
struct PointPairs {
  Column<Vec3d> from, to;
  BoxPairing pairing = BoxPairing::kAll;
  bool closed = false;  ///< true: a triangle that contains an end point also blocks

  /// The number of pairs.
  std::size_t size() const {
    return pairing == BoxPairing::kAll ? from.size() * to.size() : from.size();
  }
  /// The ray that decides pair i: something blocks the pair if the ray meets a triangle. The ray
  /// starts at `from`; its direction is to - from, each coordinate rounded once; t is in [0, 1] if
  /// `closed`, else in [2^-1074, 1 - 2^-53]. For two equal points the ray is that point alone if
  /// `closed`, else a ray that meets nothing. Precondition: i < size().
  Ray ray(std::size_t i) const;
};

/// The first invalid pair, as indices in PointPairs::from and to.
struct PairFault {
  std::size_t from = 0, to = 0;
};

/// Finds the first pair whose difference is not finite. Returns true if there is none; `fault` is
/// then unspecified. Preconditions: the points are finite; for kEach, `from` and `to` have equal
/// sizes.
bool check_pairs(const PointPairs& pairs, PairFault& fault);

}  // namespace sightline

// Tests: tests/unit/run/visibility_test.cpp
