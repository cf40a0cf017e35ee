#pragma once
/// How far two selections of a scene are from each other: question and answer.

#include <cstdint>
#include <limits>

#include "core/base/column.h"
#include "core/geometry/vec3.h"
#include "core/query/hit_batch.h"

namespace sightline {

/// Which pairs are wanted.
enum class ClearancePairs {
  kClosest,    ///< the closest pair of triangles
  kTriangles,  ///< all pairs of triangles within the distance
  kNodes,      ///< of all pairs of nodes within the distance the closest pair of triangles
};

struct ClearanceQuestion {
  ClearancePairs pairs = ClearancePairs::kClosest;
  double max_distance = std::numeric_limits<double>::infinity();  ///< closed
  std::uint64_t limit = 1000;                                     ///< pairs listed
  /// Pairs that the search may find before `limit` cuts them: more are an error.
  std::uint64_t total_max = std::numeric_limits<std::uint64_t>::max();
};

/// A triangle of the first selection and a triangle of the second.
struct ClearancePair {
  TriangleId a, b;
  double distance = 0;  ///< correctly rounded
  Vec3d on_a, on_b;     ///< points of both that are so far apart, correctly rounded
};

struct ClearanceAnswer {
  Column<ClearancePair> pairs;  ///< by (a, b), or by (node of a, node of b)
  std::uint64_t total = 0;      ///< more than there are pairs where the limit cut them
};

}  // namespace sightline
