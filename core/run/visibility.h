#pragma once
/// Visibility between points: whether segments are blocked, and the first blocker.

#include "core/query/point_pairs.h"
#include "core/run/engine.h"

namespace sightline {

/// For so many at a time there are rays.
inline constexpr std::size_t kPairsAtOnce = 131072;

/// Whether nothing of the scene stands between the points of each pair: 1 or 0. `visible` is
/// resized and overwritten. With `blockers` also what is met first from `from`, t being the part of
/// the way; of visible pairs a miss. Errors: those of Engine::any. Precondition: the pairs have
/// passed check_pairs. Memory: rays for kPairsAtOnce pairs, whatever their number.
Status visibility(const Engine& engine, const Scene& scene, const PointPairs& pairs,
                  const Deadline& deadline, const RayOptions& options,
                  Column<std::uint8_t>& visible, HitBatch* blockers);

}  // namespace sightline
