#pragma once
/// What a traversal counts, and when it stops.

#include <cstdint>

#include "core/base/deadline.h"

namespace sightline {

/// How often a stage was needed, for tests, benchmarks and metrics.
struct DecisionCounts {
  std::uint64_t exact_hits = 0;       ///< triangles decided by the exact predicate
  std::uint64_t exact_compares = 0;   ///< pairs of t compared exactly
  std::uint64_t exact_roundings = 0;  ///< winners whose t was rounded by the exact predicate
};

/// Counted per call, added to what is there; and how long the call may take.
struct TraceCounts {
  /// Polled at intervals by single rays and interleaved rays, so that no ray goes on for long after
  /// it. Null: no deadline.
  const Deadline* deadline = nullptr;
  bool stopped = false;  ///< it had passed: the answers of this call are unusable
  bool is_too_late() {
    stopped = stopped || (deadline != nullptr && deadline->passed());
    return stopped;
  }
  std::uint64_t nodes = 0;          ///< wide nodes whose eight boxes were tested
  std::uint64_t blocks = 0;         ///< leaf blocks of four triangles that were tested
  std::uint64_t placements = 0;     ///< placements entered
  std::uint64_t packet_rays = 0;    ///< rays that went in packets
  std::uint64_t packet_nodes = 0;   ///< nodes that packets opened
  std::uint64_t packet_boxes = 0;   ///< boxes that were tested for all rays of a packet at once
  std::uint64_t packet_leaves = 0;  ///< leaves that packets visited
  DecisionCounts decisions{};
};

}  // namespace sightline

// Tests: tests/unit/trace/kernel_test.cpp
