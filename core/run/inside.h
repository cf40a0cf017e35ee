#pragma once
/// Counts the open edges of the meshes of a scene: edges at which a mesh is not closed
/// (core/scene/open_edges.h). If a mesh has open edges, "inside" is not defined everywhere.

#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/query/inside_answers.h"
#include "core/scene/scene.h"

namespace sightline {

/// Returns the number of open edges of the triangles that count, summed over all placements that
/// are not hidden. For kParity these are the unpaired edges, for kWinding the unbalanced edges.
/// `resolved` may be null: all triangles count. The edges of each mesh are counted without those of
/// other meshes. If the result is 0, every answer of Engine::inside is right. Errors: DEADLINE,
/// CANCELLED, those of `reserve`, which is called before memory is allocated. Throws
/// std::bad_alloc.
Result<std::uint64_t> open_edges(const Scene& scene, const ResolvedFilter* resolved,
                                 InsideMethod method, const Deadline& deadline,
                                 const ReserveBytes& reserve);

}  // namespace sightline
