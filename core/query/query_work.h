#pragma once
/// QueryWork: the cost of a query as counts of operations. Engine adds to it (RayOptions::work).
/// RayCosts: the cost of each ray.

#include <cstdint>

#include "core/base/column.h"

namespace sightline {

/// Counts of one query, or sums over several.
struct QueryWork {
  std::uint64_t nodes = 0;       ///< tree nodes whose eight boxes were tested
  std::uint64_t blocks = 0;      ///< leaf blocks (of up to four triangles) that were tested
  std::uint64_t placements = 0;  ///< placements of meshes (instances) whose tree was entered
  /// Decisions that float64 left open and exact arithmetic made: ray against triangle, order of two
  /// hits, rounding of t.
  std::uint64_t exact_hits = 0, exact_compares = 0, exact_roundings = 0;
  /// Trees of this scene that were built while the query ran, also for other queries.
  std::uint64_t trees_built = 0;

  /// All exact decisions.
  std::uint64_t exact() const { return exact_hits + exact_compares + exact_roundings; }
};

/// The cost of each ray of a batch, traced alone: QueryWork::nodes and blocks, a slot for each ray.
struct RayCosts {
  Column<std::uint32_t> nodes, blocks;
};

}  // namespace sightline

// Tests: tests/unit/run/engine_test.cpp
