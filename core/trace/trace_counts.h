#pragma once
/// TraceCounts: counts of the steps of a traversal, and its deadline, which a kernel polls.

#include <cstdint>

#include "core/base/deadline.h"

namespace sightline {

/// How often exact decisions were needed, for tests, benchmarks and metrics.
struct DecisionCounts {
  std::uint64_t exact_hits = 0;       ///< triangles decided by the exact predicate
  std::uint64_t exact_compares = 0;   ///< pairs of t compared exactly
  std::uint64_t exact_roundings = 0;  ///< winners whose t was rounded by the exact predicate
};

/// Counts and deadline of one call of a kernel. The call adds to the counts; the caller sets
/// `deadline`, which must outlive the call.
struct TraceCounts {
  /// Polled at intervals, so that no ray continues for long after it. Null: no deadline.
  const Deadline* deadline = nullptr;
  bool stopped = false;  ///< the deadline has passed: the answers of the call are unusable
  /// Polls the deadline; returns and remembers whether it has passed.
  bool is_too_late() {
    stopped = stopped || (deadline != nullptr && deadline->passed());
    return stopped;
  }
  std::uint64_t nodes = 0;          ///< wide nodes whose eight boxes were tested
  std::uint64_t blocks = 0;         ///< leaf blocks of up to four triangles that were tested
  std::uint64_t placements = 0;     ///< placements whose tree was entered, for each ray
  std::uint64_t packet_rays = 0;    ///< rays that were traced in packets
  std::uint64_t packet_nodes = 0;   ///< nodes that packets opened
  std::uint64_t packet_boxes = 0;   ///< boxes that were tested for all rays of a packet at once
  std::uint64_t packet_leaves = 0;  ///< leaves that packets visited
  DecisionCounts decisions{};
};

}  // namespace sightline

// Tests: tests/unit/trace/kernel_test.cpp
