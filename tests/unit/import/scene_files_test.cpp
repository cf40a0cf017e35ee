#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/import/import.h"
#include "tests/support/data_folder.h"

// The files that other readers have measured: ../shared/data/scenes/scenes.json, which leaves out
// skins and morph weights, and tests/data/scenes/features*, the part of them that is kept here.

namespace sightline {
namespace {

struct Measured {
  std::uint64_t unique_triangles = 0, placed_triangles = 0, placed_primitives = 0;
  Box3d bounds;
  /// How far a position may move when it is rounded to float32 after decoding, which the readers
  /// behind scenes.json do not do: half an ulp of a number up to 1, through the matrix.
  double decoding = 0;
};

/// Bounds are of the corners of every triangle, in float64.
Measured measure(const SceneDescription& scene) {
  Measured m;
  for (const auto& mesh : scene.meshes) m.unique_triangles += mesh->triangle_count();
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[instance.mesh];
    m.placed_triangles += mesh.triangle_count();
    m.placed_primitives += mesh.primitives.size();
    for (const auto& row : instance.world_from_mesh.m) {
      m.decoding = std::max(m.decoding,
                            0x1p-25 * (std::fabs(row[0]) + std::fabs(row[1]) + std::fabs(row[2])));
    }
    const std::set<std::uint32_t> used(mesh.indices.begin(), mesh.indices.end());
    for (std::uint32_t vertex : used) {
      m.bounds.include(instance.world_from_mesh.apply(mesh.positions[vertex]));
    }
  }
  return m;
}

/// scenes.json prints eight significant digits.
double printed_digit(double value) {
  return value == 0 ? 0 : std::pow(10, std::floor(std::log10(std::fabs(value))) - 7);
}

void expect_near_printed(const Vec3d& value, const nlohmann::json& printed, double more) {
  for (int axis = 0; axis < 3; ++axis) {
    const double wanted = printed[static_cast<std::size_t>(axis)].get<double>();
    EXPECT_NEAR(value[axis], wanted, 0.51 * printed_digit(wanted) + more) << "axis " << axis;
  }
}

/// The reader behind scenes.json takes node matrices apart into translation, rotation and scale,
/// which loses the shear of one node of features: the lowest y of the scene is -0.74849697 by the
/// matrix that the file states, not -0.72696776 as scenes.json says. FeaturesFile
/// (features_file_test.cpp) computes it from the file's bytes.
bool is_without_shear(const std::string& name, const nlohmann::json& stats) {
  return name.rfind("features", 0) == 0 && stats["scene"] == 1;
}

/// The knight stands in the pose that it was bound in, so its skin gives back the vertices that the
/// readers behind scenes.json leave unskinned, but for inverse bind matrices of float32.
/// SkinnedFile (skinning_test.cpp) computes it from the file's bytes, to the last bit of float32.
double lost_by_binding(const std::string& name, const Box3d& bounds) {
  return name == "knight_skinned.glb" ? 0x1p-21 * (bounds.max.y - bounds.min.y) : 0;
}

void expect_measured(const std::filesystem::path& file, nlohmann::json stats, bool is_quantized) {
  ImportOptions options;
  options.scene = stats["scene"].get<std::uint32_t>();
  SCOPED_TRACE(file.filename().string() + ", scene " + std::to_string(*options.scene));
  const auto scene = import_file(file, options);
  ASSERT_TRUE(scene.ok()) << scene.error().code << " " << scene.error().message;
  const Measured m = measure(*scene);
  EXPECT_EQ(scene->nodes.size(), stats["nodes"]);
  EXPECT_EQ(m.unique_triangles, stats["unique_triangles"]);
  EXPECT_EQ(m.placed_triangles, stats["instanced_triangles"]);
  EXPECT_EQ(m.placed_primitives, stats["primitive_instances"]);
  EXPECT_EQ(scene->counts.skipped_primitives, stats["skipped_primitives"]);
  if (stats["min"].is_null()) {
    EXPECT_TRUE(m.bounds.empty());
  } else {
    if (is_without_shear(file.filename().string(), stats)) {
      EXPECT_EQ(stats["min"][1], -0.72696776);
      stats["min"][1] = -0.74849697;
    }
    const double lost =
        (is_quantized ? m.decoding : 0) + lost_by_binding(file.filename().string(), m.bounds);
    expect_near_printed(m.bounds.min, stats["min"], lost);
    expect_near_printed(m.bounds.max, stats["max"], lost);
  }
  if (stats["default"].get<bool>()) {
    const auto by_default = import_file(file, {});
    ASSERT_TRUE(by_default.ok());
    EXPECT_EQ(by_default->name, scene->name);
    EXPECT_EQ(by_default->instances.size(), scene->instances.size());
  }
}

nlohmann::json read_json(const std::filesystem::path& file) {
  std::ifstream in(file);
  return nlohmann::json::parse(in);
}

constexpr const char* kFiles[] = {
    "city_gpu_instancing.glb", "city_nodes.glb",      "features.glb",      "features_datauri.gltf",
    "features_external.gltf",  "furnished_house.glb", "jacksboro_dem.glb", "knight_skinned.glb",
    "pandora_map.glb",         "skull.glb",           "spot.glb",          "spot_draco.glb",
    "spot_meshopt.glb",        "spot_quantized.glb"};

class SceneFiles : public testing::TestWithParam<const char*> {};

TEST_P(SceneFiles, agree_with_what_other_readers_measured) {
  const auto data = test::data_folder();
  if (!data) GTEST_SKIP() << "no shared data folder (set SIGHTLINE_DATA)";
  const std::string name = GetParam();
  const bool is_quantized = name == "spot_quantized.glb" || name == "spot_meshopt.glb";
  std::size_t scenes = 0;
  for (const auto& entry : read_json(*data / "scenes" / "scenes.json")) {
    if (entry["file"] != name) continue;
    for (const auto& stats : entry["stats"]) {
      expect_measured(*data / "scenes" / name, stats, is_quantized);
      ++scenes;
    }
  }
  EXPECT_GT(scenes, 0u);
}

INSTANTIATE_TEST_SUITE_P(Files, SceneFiles, testing::ValuesIn(kFiles), [](const auto& file) {
  std::string name = file.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(SceneFilesList, is_all_that_other_readers_measured) {
  const auto data = test::data_folder();
  if (!data) GTEST_SKIP() << "no shared data folder (set SIGHTLINE_DATA)";
  std::set<std::string> measured;
  for (const auto& entry : read_json(*data / "scenes" / "scenes.json")) {
    measured.insert(entry["file"].get<std::string>());
  }
  EXPECT_EQ(measured, std::set<std::string>(std::begin(kFiles), std::end(kFiles)));
}

}  // namespace
}  // namespace sightline
