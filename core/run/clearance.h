#pragma once
/// How far two selections of a scene are from each other, exactly.

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/query/clearance.h"
#include "core/query/hit_filter.h"
#include "core/query/query_work.h"
#include "core/scene/scene.h"

namespace sightline {

/// Which pairs of a triangle that `a` keeps and one that `b` keeps are wanted (sides are all or
/// none); a triangle that both keep is at no distance from itself. `work`: nodes are pairs of
/// boxes. Errors: TOO_MANY_HITS for more than `most` pairs, DEADLINE, CANCELLED, MEMORY_EXHAUSTED.
/// On one thread. Cost: n log n for trees over both selections (for one, where they are the same),
/// then what is near to each other.
Status clearance(const Scene& scene, const KeptSides& a, const KeptSides& b,
                 const ClearanceQuestion& question, std::uint64_t most, const Deadline& deadline,
                 ClearanceAnswer& answer, QueryWork& work);

/// Whether both selections of a scene are the same triangles.
bool keep_the_same(const KeptSides& a, const KeptSides& b);

}  // namespace sightline
