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

/// Makes a scene of the bytes of a .glb, or of a .gltf without neighbours. Its geometry is where
/// `overflow_for` says; trees of geometry in overflow memory are built when needed. Errors: those of
/// import, of Scene::build and of move_geometry.
Result<std::shared_ptr<const Scene>> load_scene(const LoadInput& input,
                                                Laziness laziness = Laziness::kWhenNeeded,
                                                const OverflowFor& overflow_for = {});

/// Checks that the file, or the demo, exists; reads nothing. Errors: SOURCE_NOT_FOUND.
Status check_source(const std::string& source);
/// Loads a source. with_attributes: hits may need vertex attributes. overflow_for: as in load_scene.
/// Errors: those of check_source and of load_scene.
Result<PreloadedScene> load_source(const std::string& source, const SceneChoice& choice,
                                   Progress& progress, Laziness laziness = Laziness::kWhenNeeded,
                                   bool with_attributes = true,
                                   const OverflowFor& overflow_for = {});

/// The GLB of a demo by its name without "demo:". Errors: SOURCE_NOT_FOUND.
Result<std::vector<std::byte>> demo_glb(const std::string& name);

}  // namespace sightline

// Tests: tests/unit/server/cli_test.cpp
