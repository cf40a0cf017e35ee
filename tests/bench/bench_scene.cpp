#include "tests/bench/bench_scene.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include "core/demo/demo.h"
#include "core/demo/random.h"
#include "core/import/import.h"
#include "tests/support/data_folder.h"

namespace sightline::bench {

namespace {

struct Recipe {
  const char* name;
  Viewpoints viewpoints;
  const char* file;  ///< in the data folder, or null: generated
};

constexpr Recipe kRecipes[] = {
    {"terrain", Viewpoints::kGround, nullptr},
    {"scan", Viewpoints::kAround, "scenes/skull.glb"},
    {"soup", Viewpoints::kWithin, nullptr},
    {"city", Viewpoints::kGround, nullptr},
    {"instances", Viewpoints::kWithin, nullptr},
    {"furnished_house", Viewpoints::kInterior, "scenes/furnished_house.glb"},
    {"pandora_map", Viewpoints::kInterior, "scenes/pandora_map.glb"},
    {"jacksboro_dem", Viewpoints::kGround, "scenes/jacksboro_dem.glb"},
};

std::optional<std::filesystem::path> file_of(const Recipe& recipe) {
  const auto folder = test::data_folder();
  if (recipe.file == nullptr || !folder) return std::nullopt;
  const auto file = *folder / recipe.file;
  if (!std::filesystem::exists(file)) return std::nullopt;
  return file;
}

/// Stands in for a scan: a dense ball with bumps.
demo::DemoScene bumpy_ball(std::uint32_t triangles) {
  demo::DemoScene scene = demo::sphere(triangles);
  for (demo::DemoMesh& mesh : scene.meshes) {
    for (std::size_t i = 0; i + 2 < mesh.positions.size(); i += 3) {
      float* p = &mesh.positions[i];
      const double bump =
          1 + 0.2 * demo::fractal_noise(static_cast<double>(p[0] + 2 * p[1]),
                                        static_cast<double>(p[2] - p[1]), 0.7, 8, 5);
      for (int k = 0; k < 3; ++k) p[k] = static_cast<float>(static_cast<double>(p[k]) * bump);
    }
  }
  return scene;
}

demo::DemoScene generate(const std::string& name, unsigned smaller) {
  if (name == "terrain") return demo::terrain(1'000'000 / smaller);
  if (name == "soup") return demo::soup(200'000 / smaller);
  if (name == "city") return demo::city(500'000 / smaller);
  if (name == "instances") return demo::instances(10'000 / smaller, 20'000);
  return bumpy_ball(100'000 / smaller);
}

Error unknown_scene(const std::string& name) {
  return {ErrorKind::kNotFound, "BENCH_SCENE_UNKNOWN", "there is no scene '" + name + "'", ""};
}

Result<SceneDescription> describe(const Recipe& recipe, unsigned smaller) {
  if (const auto file = file_of(recipe)) return import_file(*file, {});
  if (recipe.file != nullptr && std::string(recipe.name) != "scan") {
    return Error{ErrorKind::kNotFound, "BENCH_SCENE_ABSENT",
                 std::string(recipe.file) + " is not in the data folder", ""};
  }
  return import_bytes(demo::write_glb(generate(recipe.name, smaller)), {});
}

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const Recipe& recipe : kRecipes) {
    if (recipe.file == nullptr || std::string(recipe.name) == "scan" || file_of(recipe)) {
      names.emplace_back(recipe.name);
    }
  }
  return names;
}

Result<std::filesystem::path> bench_scene_file(const std::string& name, unsigned smaller,
                                               const std::filesystem::path& folder) {
  for (const Recipe& recipe : kRecipes) {
    if (name != recipe.name) continue;
    if (auto file = file_of(recipe)) return *file;
    const auto file = folder / (name + ".glb");
    const auto bytes = demo::write_glb(generate(name, smaller));
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return file;
  }
  return unknown_scene(name);
}

Result<BenchScene> load_bench_scene(const std::string& name, unsigned smaller) {
  for (const Recipe& recipe : kRecipes) {
    if (name != recipe.name) continue;
    Result<SceneDescription> description = describe(recipe, smaller);
    if (!description) return std::move(description).error();
    const auto start = std::chrono::steady_clock::now();
    auto scene = Scene::build(std::move(*description));
    if (!scene) return std::move(scene).error();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    return BenchScene{name, recipe.viewpoints, std::move(*scene), seconds.count()};
  }
  return unknown_scene(name);
}

}  // namespace sightline::bench
