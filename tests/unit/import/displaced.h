#pragma once
/// The same surface twice, its vertices a little displaced: which answers may differ, and by how
/// much.
///
/// Triangle T has the corners of T' but for a displacement of at most `moved` each.
///   1. The point of T' that a ray meets is within `moved` of a point of T (that with the same
///      weights), so the ray's two t obey |n . d| |t - t'| <= moved, n being T's unit normal.
///   2. A ray that meets T and not T' meets an edge of a triangle between the two (move the corners
///      steadily), so it passes an edge of T within `moved`.
/// A closest hit on another triangle, or none, follows from 1 and 2 for the triangles concerned.
/// Nothing else may happen.

#include <cstddef>
#include <functional>
#include <string>

#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene.h"

namespace sightline::test {

struct DisplacedSurface {
  const Scene& plain;
  const Scene& displaced;
  /// The triangle of `plain` that a triangle of `displaced` was.
  std::function<TriangleId(TriangleId)> origin_of;
  /// No corner of this triangle of `plain` moved farther.
  std::function<double(TriangleId)> moved;
};

struct DisplacedTally {
  std::size_t rays = 0, hits = 0;
  std::size_t same_bits = 0;  ///< hits with the same triangle and the same t, to the bit
  std::size_t same_triangle = 0;
  std::size_t other_triangle = 0;  ///< both hit, explained
  std::size_t hit_and_miss = 0;    ///< explained
  std::size_t unexplained = 0;
  double largest = 0;  ///< |t - t'| |d| of the same triangle

  std::string text() const;
};

/// Compares answers of both for the same rays; the first unexplained one is described in
/// `complaint`.
DisplacedTally compare_displaced(const DisplacedSurface& surface, const RayBatch& rays,
                                 const HitBatch& plain, const HitBatch& displaced,
                                 std::string& complaint);

/// Rays from around the box to points in and a little around it.
RayBatch rays_at(const Box3d& box, std::size_t count, std::uint64_t seed);

/// Closest hits, on one thread.
HitBatch closest_of(const Scene& scene, const RayBatch& rays);

}  // namespace sightline::test
