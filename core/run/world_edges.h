#pragma once
/// Open edges of a scene's meshes, in the world.

#include <vector>

#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/scene/scene.h"
#include "core/trace/search/solid_angle.h"

namespace sightline {

/// The open edges of the triangles that count, of all placements that are not hidden; `resolved` may
/// be null. The edges of each mesh are found without those of other meshes. Errors: DEADLINE,
/// CANCELLED, those of `reserve`. Throws std::bad_alloc.
Result<std::vector<OpenEdge>> open_edges_in_world(const Scene& scene,
                                                  const ResolvedFilter* resolved,
                                                  const Deadline& deadline,
                                                  const ReserveBytes& reserve);

}  // namespace sightline

// Tests: tests/unit/run/solid_angle_test.cpp
