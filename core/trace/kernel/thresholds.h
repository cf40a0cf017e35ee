#pragma once
/// Every threshold of the batch paths in one table. They change speed, never an answer.
///
/// Measured by trace_bench with one value changed at a time, several runs in turn, all kernels in
/// one run (docs/decisions/0022 has the figures):
///   trace_bench --judge 0 --kernel avx2
///     --contestant 'sightline,sightline_64,sightline@sse4,sightline@avx512,embree1'
/// No value was better for one instruction set and worse for another by more than the spread of the
/// runs, so that the kernels share one column.

#include <cstddef>
#include <cstdint>

namespace sightline::thresholds {

/// Rays in flight in interleaved traversal: through one tree, and in a scene of several entries.
/// More rays hide more latency and take more of the first-level cache.
inline constexpr std::size_t kInFlight = 32, kInFlightMany = 48;

/// Neighbouring rays of a packet: at least, usually, and at most where they share much.
inline constexpr std::size_t kFewestRays = 4, kNarrowRays = 32, kPacketRays = 64;
/// Rays of a packet of kNarrowRays that wait at a node or box in the mean, before it may be wide.
inline constexpr std::uint64_t kFewestPerStepIfWide = 2;
/// A triangle is filtered for rays side by side if they fill at least kFullRays / kFullOf of the
/// lanes that triangles side by side fill.
inline constexpr std::uint32_t kFullRays = 3, kFullOf = 4;

/// Rays of a masked packet over several entries that wait at a node in the mean: with fewer the
/// interleaved traversal is faster.
inline constexpr std::uint64_t kFewestPerNode = 5;

/// Rays of a sorted packet that wait at a node or box in the mean: to go on sorting, to begin.
inline constexpr double kFewestPerStepIfSorted = 1.5, kFewestToBeginSorting = 1.7;

}  // namespace sightline::thresholds

// Tests: tests/unit/trace/kernel_test.cpp
