#pragma once
/// Asks a scene about random rays twice: as ever, and by brute force.

#include <cstdint>
#include <vector>

#include "core/run/engine.h"

namespace sightline {

struct SelfCheck {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;       ///< of rays that meet anything
  std::uint64_t triangles = 0;  ///< decided exactly by brute force, for all rays
  /// Numbers of rays whose closest hit or whose count differ. There should be none.
  std::vector<std::uint64_t> different;
};

/// Rays in the scene's bounds and around them, aimed at random triangles: at their corners, edges
/// and insides, and past them. Brute force is the exact predicate (exact_hit.h) on every triangle
/// of every instance: no tree, no filter.
/// Errors: DEADLINE, CANCELLED, MEMORY_EXHAUSTED. Cost: instances, and rays times triangles; takes
/// 4 bytes for each instance.
Result<SelfCheck> self_check(const Engine& engine, const Scene& scene, std::uint64_t rays,
                             std::uint64_t seed, const Deadline& deadline);

}  // namespace sightline

// Tests: tests/integration/parts_test.py
