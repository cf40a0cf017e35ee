#pragma once
/// The scenes of the cross-check: the project's generated ones, some small hard ones, and every
/// file of the shared scenes that loads.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/demo/demo.h"
#include "core/scene/scene_description.h"

namespace sightline::crosscheck {

struct NamedScene {
  std::string name;
  std::function<Result<SceneDescription>()> load;
};

/// Always the same, made from seeds.
std::vector<NamedScene> generated_scenes();
/// One per .glb and .gltf file of the folder, by name; load() may answer with an error.
std::vector<NamedScene> file_scenes(const std::filesystem::path& folder);

/// A demo scene as a description, without the road over a file.
SceneDescription describe(const demo::DemoScene& scene);

}  // namespace sightline::crosscheck
