#pragma once
/// Describes a scene of the store as JSON.

#include <string>
#include <vector>

#include "core/store/scene_store.h"

namespace sightline {

/// Returns {"id","state","revision","sha256","bytes","scene","persistent","name","counts","bounds",
/// "warnings"}. A failed scene has {"id","state","reason":{"code","detail"}}. A loading one has
/// {"id","state","stage","progress"}, where progress is the percentage of the stage, or null.
/// "update" describes a newer content of a ready scene that is on its way or has failed. "scene" is
/// present if ?scene=N chose it. Bounds are null for a scene without finite triangles. At most 100
/// warnings; "warnings_total" is the number of all.
std::string encode_scene(const StoredScene& scene);
/// An upper bound of the bytes that encode_scene allocates for the scene.
std::uint64_t bytes_of_scene(const StoredScene& scene);
/// The scene in one line: encode_scene without name, counts, bounds and warnings. "triangles" is
/// the number of triangles of all instances.
std::string encode_scene_summary(const StoredScene& scene);
/// Returns {"scenes":[...]}, each as in encode_scene_summary.
std::string encode_scene_list(const std::vector<SceneSnapshot>& scenes);

}  // namespace sightline
