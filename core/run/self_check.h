#pragma once
/// Compares the answers for random rays with those of brute force: a test of an engine on a loaded
/// scene.

#include <cstdint>
#include <vector>

#include "core/run/engine.h"

namespace sightline {

/// The result of a self check.
struct SelfCheck {
  std::uint64_t rays = 0;       ///< rays that were traced; fewer if no valid rays can be drawn
  std::uint64_t hits = 0;       ///< rays that hit a triangle
  std::uint64_t triangles = 0;  ///< exact decisions of brute force, for all rays
  /// Indices of rays whose closest hit or number of hits differs from brute force. Empty if the
  /// engine is right.
  std::vector<std::uint64_t> different;
};

/// Traces `rays` random rays, drawn from `seed`, twice: with the engine, and by brute force. Brute
/// force tests every triangle of every instance that is not hidden with the exact predicate
/// (exact_hit.h), without a tree. The rays start in the scene's bounds and around them, and
/// aim at corners, edges and insides of random triangles, and past them. Errors: DEADLINE,
/// CANCELLED, MEMORY_EXHAUSTED. Cost: instances, plus rays times triangles, about 25 ns each;
/// memory of 4 bytes for each instance, the rays and their hits, and self_check_bytes().
Result<SelfCheck> self_check(const Engine& engine, const Scene& scene, std::uint64_t rays,
                             std::uint64_t seed, const Deadline& deadline);

/// Bytes that brute force takes in self_check() of `rays` rays.
std::uint64_t self_check_bytes(std::uint64_t rays);

}  // namespace sightline

// Tests: tests/integration/parts_test.py
