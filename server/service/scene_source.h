#pragma once
/// Scenes that a command line names: "town.glb", or "demo:town", "demo:six" and "demo:painted",
/// which this program makes itself.

#include <optional>
#include <span>
#include <string>

#include "core/store/scene_store.h"

namespace sightline {

/// When a scene's trees are built. No answer depends on it.
enum class Laziness {
  kEager,       ///< before the scene is ready
  kWhenNeeded,  ///< when rays come near, or in the background
};

/// The bytes of a .glb, or of a .gltf without neighbours, as a scene. Errors: those of import and
/// of Scene::build.
Result<std::shared_ptr<const Scene>> load_scene(const LoadInput& input,
                                                Laziness laziness = Laziness::kWhenNeeded);

/// Errors: SOURCE_NOT_FOUND (no such file, no demo of that name). Cheap: reads nothing.
Status check_source(const std::string& source);
/// with_attributes  whether hits may be asked for the attributes of vertices.
/// Errors: also those of import and of Scene::build.
Result<PreloadedScene> load_source(const std::string& source, const SceneChoice& choice,
                                   Progress& progress, Laziness laziness = Laziness::kWhenNeeded,
                                   bool with_attributes = true);

/// The GLB of a demo by its name without "demo:". Errors: SOURCE_NOT_FOUND.
Result<std::vector<std::byte>> demo_glb(const std::string& name);

}  // namespace sightline
