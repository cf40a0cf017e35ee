#pragma once
/// Warnings about names in a request that match nothing of the scene.

#include <span>
#include <string>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/query/selection_warning.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// Appends a warning, or returns it as an error, 422 SELECTION_EMPTY, if `warnings` is null.
Status tell(SelectionWarning warning, SelectionWarnings* warnings);

/// Tells each of the names of fields (attribute_name.h) that no primitive of the scene has, with
/// similar ones. Errors: those of tell() and of the deadline. Throws std::bad_alloc.
Status tell_unknown_fields(const SceneDescription& scene, std::span<const std::string> names,
                           const Deadline& deadline, SelectionWarnings* warnings);

}  // namespace sightline

// Tests: tests/integration/custom_attributes_test.py
