#pragma once
/// Statistics of a scene's trees, as plain data. Counters count since the scene was made.

#include <cstdint>

namespace sightline {

/// Statistics of one scene.
struct TreeStats {
  std::uint64_t meshes_total = 0;   ///< meshes with different content
  std::uint64_t meshes_built = 0;   ///< meshes that have a tree, or a tree of a part, now
  std::uint64_t trees_built = 0;    ///< counter: trees that were built for a query
  std::uint64_t trees_kept = 0;     ///< trees reused from the previous revision, if a node changed
  std::uint64_t meshes_split = 0;   ///< counter: large meshes that were split into parts
  std::uint64_t full_builds = 0;    ///< counter: builds of all trees at once
  std::uint64_t evictions = 0;      ///< counter: evictions of all trees for lack of memory
  std::uint64_t cache_hits = 0;     ///< counter: times that all trees were read from a valid file
  std::uint64_t cache_rejects = 0;  ///< counter: files of trees that were invalid
  /// counter: rays and boxes that had to wait for an unbuilt tree
  std::uint64_t queries_waited = 0;
  std::uint64_t tree_bytes = 0;      ///< bytes of the trees that exist now
  std::uint64_t geometry_bytes = 0;  ///< bytes of positions and indices
  bool complete = false;             ///< no tree is unbuilt
};

/// Sums over all scenes that have joined a TreeBudget. Counters include removed scenes.
struct TreeTotals {
  std::uint64_t trees_built = 0, full_builds = 0, evictions = 0;  ///< counters, as in TreeStats
  /// counters, as in TreeStats
  std::uint64_t cache_hits = 0, cache_rejects = 0, queries_waited = 0;
  std::uint64_t tree_bytes = 0;  ///< of present scenes
  /// of present scenes; geometry that several scenes share counts once
  std::uint64_t geometry_bytes = 0;
  std::uint64_t overflow_bytes = 0;  ///< bytes of the files of OverflowMemory
  std::uint64_t evicted_bytes = 0;   ///< counter: OverflowMemory::evicted_bytes
};

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
