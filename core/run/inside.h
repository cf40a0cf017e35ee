#pragma once
/// Open edges: where a mesh has them, inside is not defined everywhere.

#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/query/inside_answers.h"
#include "core/scene/scene.h"

namespace sightline {

/// The number of open edges of the triangles that count, for this method, summed over all
/// placements. Without open edges every answer is right. Each mesh is examined alone. Errors:
/// DEADLINE, CANCELLED, those of `reserve`. Throws std::bad_alloc.
Result<std::uint64_t> open_edges(const Scene& scene, const ResolvedFilter* resolved,
                                 InsideMethod method, const Deadline& deadline,
                                 const ReserveBytes& reserve);

}  // namespace sightline
