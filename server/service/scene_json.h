#pragma once
/// A scene of the store as JSON, for people and programs.

#include <string>
#include <vector>

#include "core/store/scene_store.h"

namespace sightline {

/// {"id","state","revision","sha256","bytes","scene","persistent","name","counts","bounds",
/// "warnings"}; of a failed scene {"id","state","reason":{"code","detail"}}; of one that is loading
/// {"id","state","stage","progress"}, where progress is that of the stage in percent, or null.
/// "update" says the same of a newer content of a ready scene, while it is on its way or when it
/// failed. "scene" is there when ?scene=N chose it. Bounds are null for a scene without finite
/// triangles. At most 100 warnings; "warnings_total" counts them all.
std::string encode_scene(const StoredScene& scene);
/// An upper bound of the bytes of that text; names and warnings are as long as in the file.
std::uint64_t bytes_of_scene(const StoredScene& scene);
/// The scene in one line, without name, counts, bounds and warnings.
std::string encode_scene_summary(const StoredScene& scene);
/// {"scenes":[...]}, each without bounds and warnings.
std::string encode_scene_list(const std::vector<SceneSnapshot>& scenes);

}  // namespace sightline
