#pragma once
/// Rays that pass through the transparent texels of masked materials (RayOptions::alpha_cutoff).
///
/// A hit on a triangle of a masked material counts if
///     base colour alpha * (texel alpha / 255) * COLOR_0 alpha >= alphaCutoff
/// in float64, left to right. The texel is the nearest one at the rounded uv of the hit
/// (alpha_texture.h). Where the file has no texture or no TEXCOORD_0 the texel's alpha is 255,
/// where it has no COLOR_0 that alpha is 1. Hits of other materials count. So the answers depend on
/// exact hits and rounded uv alone, and are equal for all kernels and numbers of threads.
///
/// Method   hits of the plain query are tested. Rays whose hit does not count are asked again for
///          lists of their first hits, 8, 64, 512 and so on, until one counts.

#include "core/base/deadline.h"
#include "core/run/engine.h"

namespace sightline {

/// The queries of Engine with an alpha cutoff. All arguments must outlive this object.
class AlphaCutoff {
 public:
  AlphaCutoff(const Engine& engine, const Scene& scene, const Deadline& deadline,
              const RayOptions& options);

  // As the methods of Engine. Errors also: ALPHA_UNREADABLE (alpha_texture.h). Throw
  // std::bad_alloc.
  Status closest(const RayBatch& rays, HitBatch& hits) const;
  Status any(const RayBatch& rays, Column<std::uint8_t>& occluded) const;
  Status count(const RayBatch& rays, Crossings crossings, Column<std::uint64_t>& totals) const;
  /// question.total_max also bounds the hits before the test of a thousand rays at a time.
  Status all(const RayBatch& rays, const HitListQuestion& question, HitLists& lists,
             Column<std::uint64_t>& totals) const;

 private:
  /// The material of a hit if it is masked, else null.
  const Material* masked(TriangleId id) const;
  /// Sets 1 for each hit that counts, and for misses. rays[i] belongs to slot i.
  Status test(const RayBatch& rays, const HitBatch& hits, Column<std::uint8_t>& counts) const;
  /// Finds the first hits that count of some rays, by their numbers.
  Status search(const RayBatch& rays, const Column<std::size_t>& numbers, HitBatch& hits) const;

  const Engine& engine_;
  const Scene& scene_;
  const Deadline& deadline_;
  RayOptions plain_;  ///< without the cutoff
};

}  // namespace sightline

// Tests: tests/integration/alpha_cutoff_test.py
