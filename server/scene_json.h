#pragma once
/// A scene of the store as JSON, for people and programs.

#include <string>
#include <vector>

#include "core/store/scene_store.h"

namespace sightline {

/// {"id","state","revision","sha256","bytes","scene","persistent","name","counts","bounds",
/// "warnings"}; of a failed scene {"id","state","reason":{"code","detail"}}. "scene" is there when
/// ?scene=N chose it. Bounds are null for a scene without
/// finite triangles. At most 100 warnings; "warnings_total" counts them all.
std::string encode_scene(const StoredScene& scene);
/// {"scenes":[...]}, each without bounds and warnings.
std::string encode_scene_list(const std::vector<SceneSnapshot>& scenes);

}  // namespace sightline
