#pragma once
/// How far two selections of a scene are from each other, exactly.

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/query/clearance.h"
#include "core/query/hit_filter.h"
#include "core/query/query_work.h"
#include "core/scene/scene.h"

namespace sightline {

/// The pairs of a triangle selected by `a` and a triangle selected by `b` (sides are all or none).
/// A triangle in both has distance 0 to itself. `work`: nodes are pairs of boxes. Errors:
/// TOO_MANY_HITS for more than `most` pairs, DEADLINE, CANCELLED, MEMORY_EXHAUSTED. Runs on one
/// thread. Cost: n log n for a tree over each selection, then proportional to the pairs that are
/// close.
Status clearance(const Scene& scene, const ResolvedFilter& a, const ResolvedFilter& b,
                 const ClearanceQuestion& question, std::uint64_t most, const Deadline& deadline,
                 ClearanceAnswer& answer, QueryWork& work);

/// Whether both selections of a scene are the same triangles.
bool keep_the_same(const ResolvedFilter& a, const ResolvedFilter& b);

}  // namespace sightline
