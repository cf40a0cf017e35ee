#pragma once
/// The cost and savings of a scene's trees so far, as plain data.

#include <cstdint>

namespace sightline {

struct TreeStats {
  std::uint64_t meshes_total = 0;    ///< with different content
  std::uint64_t meshes_built = 0;    ///< of those, with a tree now, or with a tree for a part
  std::uint64_t trees_built = 0;     ///< because a ray or a box came near, ever
  std::uint64_t trees_kept = 0;      ///< of the revision before, when a node changed
  std::uint64_t meshes_split = 0;    ///< large meshes that were cut into parts, ever
  std::uint64_t full_builds = 0;     ///< all trees of the scene in their lasting form, ever
  std::uint64_t evictions = 0;       ///< all trees dropped for want of memory, ever
  std::uint64_t cache_hits = 0;      ///< all trees read from a file that held what it should, ever
  std::uint64_t cache_rejects = 0;   ///< a file was there and was not what it should be, ever
  std::uint64_t queries_waited = 0;  ///< rays and boxes that needed a tree that was not there, ever
  std::uint64_t tree_bytes = 0;      ///< of the trees that are there now
  std::uint64_t geometry_bytes = 0;  ///< positions and indices
  bool complete = false;             ///< nothing is left to build
};

/// Sums over all scenes that have joined a TreeBudget. Sums that are "ever" include removed scenes.
struct TreeTotals {
  std::uint64_t trees_built = 0, full_builds = 0, evictions = 0;        ///< ever, as TreeStats
  std::uint64_t cache_hits = 0, cache_rejects = 0, queries_waited = 0;  ///< ever, as TreeStats
  std::uint64_t tree_bytes = 0;                                         ///< now
  std::uint64_t geometry_bytes = 0;  ///< now; what several scenes share counts once
};

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
