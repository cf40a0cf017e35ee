#pragma once
/// Names of scenes.

#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// True for 1 to 128 characters of A-Z a-z 0-9 . _ - that do not begin with a dot. Such a name is
/// safe as a file name, in a URL and in a log, and unambiguous on every case-sensitive file system.
bool is_scene_id(std::string_view id);
/// The error SCENE_ID_INVALID, whose message states the rule.
Error scene_id_invalid();
/// Returns the error SCENE_NOT_FOUND. Its message contains `id` if that is a valid name.
Error scene_not_found(std::string_view id = {});

}  // namespace sightline

// Tests: tests/unit/store/scene_store_test.cpp
