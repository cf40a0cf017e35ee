#pragma once
/// Loads the scenes that a command line names: a file such as "town.glb", or a demo: "demo:town",
/// "demo:six", "demo:painted".

#include <optional>
#include <span>
#include <string>

#include "core/store/scene_store.h"

namespace sightline {

/// When the trees of a scene are built. No answer depends on it.
enum class Laziness {
  kEager,       ///< before the scene is ready
  kWhenNeeded,  ///< when queries need them, or in the background
};

/// Makes a scene of the bytes of a .glb, or of a .gltf without neighbours. Errors: those of import
/// and of Scene::build.
Result<std::shared_ptr<const Scene>> load_scene(const LoadInput& input,
                                                Laziness laziness = Laziness::kWhenNeeded);

/// Checks that the file, or the demo, exists; reads nothing. Errors: SOURCE_NOT_FOUND.
Status check_source(const std::string& source);
/// Loads a source. with_attributes: hits may need vertex attributes. Errors: those of check_source,
/// of import and of Scene::build.
Result<PreloadedScene> load_source(const std::string& source, const SceneChoice& choice,
                                   Progress& progress, Laziness laziness = Laziness::kWhenNeeded,
                                   bool with_attributes = true);

/// The GLB of a demo by its name without "demo:". Errors: SOURCE_NOT_FOUND.
Result<std::vector<std::byte>> demo_glb(const std::string& name);

}  // namespace sightline

// Tests: tests/unit/server/cli_test.cpp
