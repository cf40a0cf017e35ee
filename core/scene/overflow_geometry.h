#pragma once
/// Moves the positions and indices of a scene to OverflowMemory.

#include "core/base/overflow_memory.h"
#include "core/base/result.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// Replaces each mesh by one whose positions and indices are in `overflow`. Those that are there
/// already, as parts of a file, stay where they are. Sets overflow_bytes. Cost: a copy. Errors:
/// OVERFLOW_FULL; some meshes are then replaced. Throws std::bad_alloc.
Status move_geometry(SceneDescription& scene, OverflowMemory& overflow);

}  // namespace sightline

// Tests: tests/unit/scene/overflow_geometry_test.cpp
