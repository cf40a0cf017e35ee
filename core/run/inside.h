#pragma once
/// Counts the open edges of the meshes of a scene. If a mesh has open edges, "inside" is not
/// defined everywhere.

#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/query/inside_answers.h"
#include "core/scene/scene.h"

namespace sightline {

/// Returns the number of open edges of the triangles that count (resolved; null: all), for a
/// method, summed over all placements. Each mesh is examined alone. If it is 0, every answer of
/// Engine::inside is right. Errors: DEADLINE, CANCELLED, those of `reserve`. Throws std::bad_alloc.
Result<std::uint64_t> open_edges(const Scene& scene, const ResolvedFilter* resolved,
                                 InsideMethod method, const Deadline& deadline,
                                 const ReserveBytes& reserve);

}  // namespace sightline
