#pragma once
/// All thresholds with which the batch scheduler chooses between methods of traversal. They affect
/// speed, and never an answer.
///
/// Measured by trace_bench with one value changed at a time, several runs in turn, all kernels in
/// one run (docs/decisions/0022 has the figures):
///   trace_bench --judge 0 --kernel avx2
///     --contestant 'sightline,sightline_64,sightline@sse4,sightline@avx512,embree1'
/// No value was better for one instruction set and worse for another by more than the variation
/// between runs, so all kernels share the values. The exception is kInFlightMany, which was
/// measured again on a machine without AVX-512 (docs/decisions/0037).

#include <cstddef>
#include <cstdint>

namespace sightline::thresholds {

/// Rays in flight in interleaved traversal: through one tree, and in a scene of several entries.
/// More rays hide more latency of memory and need more of the first-level cache.
inline constexpr std::size_t kInFlight = 32, kInFlightMany = 24;
/// kInFlightMany of the AVX-512 kernel, as measured in docs/decisions/0022.
inline constexpr std::size_t kInFlightManyAvx512 = 48;

/// Rays of a packet: the least, the usual and the largest number.
inline constexpr std::size_t kFewestRays = 4, kNarrowRays = 32, kPacketRays = 64;
/// A packet may be wide (kPacketRays) if so many rays of a packet of kNarrowRays are active at a
/// node or box on average.
inline constexpr std::uint64_t kFewestPerStepIfWide = 2;
/// A triangle is filtered for many rays per vector if they use at least kFullRays / kFullOf of the
/// lanes that many triangles per vector use.
inline constexpr std::uint32_t kFullRays = 3, kFullOf = 4;

/// With fewer active rays of a masked packet at a node on average, interleaved traversal is faster.
inline constexpr std::uint64_t kFewestPerNode = 5;

/// Active rays of a sorted packet at a node or box on average: to continue sorting, and to begin.
inline constexpr double kFewestPerStepIfSorted = 1.5, kFewestToBeginSorting = 1.7;

}  // namespace sightline::thresholds

// Tests: tests/unit/trace/kernel_test.cpp
