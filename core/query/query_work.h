#pragma once
/// The cost of a query in counts.

#include <cstdint>

namespace sightline {

struct QueryWork {
  std::uint64_t nodes = 0;       ///< nodes of trees whose eight boxes were tested
  std::uint64_t blocks = 0;      ///< of up to four triangles that were tested
  std::uint64_t placements = 0;  ///< of meshes that were entered
  // Decisions that float64 left open, taken by integers: triangles, orders of two hits, roundings.
  std::uint64_t exact_hits = 0, exact_compares = 0, exact_roundings = 0;
  /// In this scene while the query ran, by whomever.
  std::uint64_t trees_built = 0;

  std::uint64_t exact() const { return exact_hits + exact_compares + exact_roundings; }
};

}  // namespace sightline

// Tests: tests/unit/run/engine_test.cpp
