#pragma once
/// The scenes that are traced: the five generated ones, and files when they are at hand.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/scene.h"

namespace sightline::bench {

/// Where cameras and the LiDAR stand.
enum class Viewpoints {
  kGround,    ///< low over open ground: streets, valleys
  kAround,    ///< outside, looking at the middle; the LiDAR beside the object
  kWithin,    ///< outside, looking at the middle; the LiDAR in the middle
  kInterior,  ///< in rooms
};

struct BenchScene {
  std::string name;
  Viewpoints viewpoints = Viewpoints::kAround;
  std::shared_ptr<const Scene> scene;
  double build_seconds = 0;  ///< wall time of Scene::build, all threads
};

/// "terrain", "scan", "soup", "city", "instances", then what stands beside them when files are at
/// hand ("furnished_house", "pandora_map", "jacksboro_dem").
std::vector<std::string> scene_names();
/// Takes the road of a user's file: the generated scenes are written as GLB and imported. `smaller`
/// divides the generated triangle counts.
Result<BenchScene> load_bench_scene(const std::string& name, unsigned smaller = 1);
/// The same scene as a file for a server: the one of the data folder, or one written to `folder`.
Result<std::filesystem::path> bench_scene_file(const std::string& name, unsigned smaller,
                                               const std::filesystem::path& folder);

}  // namespace sightline::bench
