#pragma once
/// Moves the positions and indices of a scene to OverflowMemory.

#include "core/base/result.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// Replaces each mesh by one whose positions and indices are in `overflow` of the scene. Those that
/// are there already, as parts of a file, stay where they are. Precondition: `overflow` is not null.
/// Cost: a copy. Errors: OVERFLOW_FULL; some meshes are then replaced. Throws std::bad_alloc.
Status move_geometry(SceneDescription& scene);

}  // namespace sightline

// Tests: tests/unit/scene/overflow_geometry_test.cpp
