#pragma once
/// ClearanceQuestion: how far two selections of triangles are from each other; and its answer.
/// Engine::clearance answers it.

#include <array>
#include <cstddef>
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

/// How two nodes lie to each other, by their triangles in the selections. The first that holds:
/// kDuplicate  both have equal triangles, in any order
/// kAInB       no two triangles cross (triangle_crossing.h), B is closed, and each corner of A is
///             inside or on the surface of B, one of them inside; kBInA: exchanged
/// kCrossing   two triangles cross, or both are convex bodies (convex_body.h) whose interiors have
///             a common point
/// kTouching   they have a common point
/// kNear       their distance is at most that of the question
/// kApart      none of these
enum class ClashKind : std::uint8_t {
  kDuplicate,
  kAInB,
  kBInA,
  kCrossing,
  kTouching,
  kNear,
  kApart
};
inline constexpr std::size_t kClashKindCount = 7;

/// The options of the question.
struct ClearanceQuestion {
  ClearancePairs pairs = ClearancePairs::kClosest;
  /// In scene units, not negative; pairs at exactly this distance count.
  double max_distance = std::numeric_limits<double>::infinity();
  std::uint64_t limit = 1000;  ///< the answer lists at most so many pairs
  /// False: pairs of triangles of one node do not count, and if both selections are equal, each
  /// pair counts once, with the node that comes first in the scene as its first.
  bool self = true;
  /// False: pairs of a node and its parent do not count.
  bool adjacent = true;
  /// True, for kNodes: each pair has its kind and depth, kinds are counted, and pairs of which one
  /// is inside of the other are listed whatever their distance.
  bool kinds = false;
  /// The search fails if it finds more pairs than this, whatever `limit` is.
  std::uint64_t total_max = std::numeric_limits<std::uint64_t>::max();
};

/// A triangle of the first selection and a triangle of the second.
struct ClearancePair {
  TriangleId a, b;
  double distance = 0;  ///< scene units, correctly rounded
  Vec3d on_a, on_b;     ///< the nearest points of both triangles, each coordinate correctly rounded
  bool triangles_cross = false;  ///< of nodes: some two of their triangles cross
  ClashKind kind = ClashKind::kApart;
  /// The penetration depth of two convex bodies that meet, correctly rounded (convex_body.h); NaN
  /// where it is not defined. `kind` and `depth` are set if the question asks for kinds.
  double depth = std::numeric_limits<double>::quiet_NaN();
};

/// The answer. `pairs` is empty if no pair is within max_distance.
struct ClearanceAnswer {
  Column<ClearancePair> pairs;  ///< sorted by (a, b), or for kNodes by (node of a, node of b)
  /// number of pairs found; larger than pairs.size() if `limit` shortened the list
  std::uint64_t total = 0;
  std::array<std::uint64_t, kClashKindCount> kinds{};  ///< number of pairs of nodes by ClashKind
};

}  // namespace sightline
