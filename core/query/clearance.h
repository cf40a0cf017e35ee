#pragma once
/// ClearanceQuestion: how far two selections of triangles are from each other; and its answer.
/// Engine::clearance answers it.

#include <cstdint>
#include <limits>

#include "core/base/column.h"
#include "core/geometry/vec3.h"
#include "core/query/hit_batch.h"

namespace sightline {

/// Which pairs the answer lists.
enum class ClearancePairs {
  kClosest,    ///< the closest pair of triangles; of pairs at equal distance the smallest (a, b)
  kTriangles,  ///< all pairs of triangles within max_distance
  kNodes,      ///< for each pair of nodes within max_distance, their closest pair of triangles
};

/// The options of the question.
struct ClearanceQuestion {
  ClearancePairs pairs = ClearancePairs::kClosest;
  /// In scene units, not negative; pairs at exactly this distance count.
  double max_distance = std::numeric_limits<double>::infinity();
  std::uint64_t limit = 1000;  ///< the answer lists at most so many pairs
  /// The search fails if it finds more pairs than this, whatever `limit` is.
  std::uint64_t total_max = std::numeric_limits<std::uint64_t>::max();
};

/// A triangle of the first selection and a triangle of the second.
struct ClearancePair {
  TriangleId a, b;
  double distance = 0;  ///< scene units, correctly rounded
  Vec3d on_a, on_b;     ///< the nearest points of both triangles, each coordinate correctly rounded
};

/// The answer. `pairs` is empty if no pair is within max_distance.
struct ClearanceAnswer {
  Column<ClearancePair> pairs;  ///< sorted by (a, b), or for kNodes by (node of a, node of b)
  /// number of pairs found; larger than pairs.size() if `limit` shortened the list
  std::uint64_t total = 0;
};

}  // namespace sightline
