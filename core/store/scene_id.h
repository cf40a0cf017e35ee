#pragma once
/// Which names a scene may have.

#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// 1 to 128 of A-Z a-z 0-9 . _ - and not beginning with a dot: safe as a file name, in a URL and in
/// a log, and unambiguous on every case-sensitive file system.
bool is_scene_id(std::string_view id);
/// SCENE_ID_INVALID, with the rule in its message.
Error scene_id_invalid();
/// SCENE_NOT_FOUND: no scene has the name.
Error scene_not_found();

}  // namespace sightline

// Tests: tests/unit/store/scene_store_test.cpp
