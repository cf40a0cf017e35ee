#include "core/import/gltf/instancing.h"

#include <gtest/gtest.h>

#include "core/import/gltf/transform.h"
#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using test::json;
using test::one_triangle;
using test::TinyFile;

TinyFile placed_three_times() {
  TinyFile file = one_triangle();
  const int t = file.add<float>({0, 0, 0, 1, 2, 3, 4, 5, 6}, 5126, "VEC3", 3);
  const int r = file.add<float>({0, 0, 0, 1, 0, 1, 0, 0, 0.5f, 0.5f, 0.5f, 0.5f}, 5126, "VEC4", 3);
  const int s = file.add<float>({1, 1, 1, 2, 3, 4, -1, 1, 1}, 5126, "VEC3", 3);
  file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", t}, {"ROTATION", r}, {"SCALE", s}, {"_ID", 0}};
  file.root["nodes"][0]["translation"] = {100, 0, 0};
  file.root["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  return file;
}

json& attributes(TinyFile& file) {
  return file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
}

TEST(Instancing, places_the_mesh_once_per_element_below_the_node) {
  const auto scene = placed_three_times().import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->instances.size(), 3u);
  EXPECT_EQ(scene->nodes.size(), 1u);
  const Affine node = from_trs({100, 0, 0}, {}, {1, 1, 1});
  const Affine wanted[3] = {node * from_trs({0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}),
                            node * from_trs({1, 2, 3}, {0, 1, 0, 0}, {2, 3, 4}),
                            node * from_trs({4, 5, 6}, {0.5, 0.5, 0.5, 0.5}, {-1, 1, 1})};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scene->instances[i].world_from_mesh, wanted[i]) << i;
    EXPECT_EQ(scene->instances[i].node, 0u);
    EXPECT_EQ(scene->instances[i].mesh, 0u);
  }
}

TEST(Instancing, takes_absent_attributes_as_the_identity) {
  TinyFile file = placed_three_times();
  attributes(file).erase("ROTATION");
  attributes(file).erase("SCALE");
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->instances[2].world_from_mesh.apply(Vec3d{0, 0, 0}), (Vec3d{104, 5, 6}));
}

TEST(Instancing, decodes_normalised_rotations) {
  TinyFile file = placed_three_times();
  attributes(file) = {
      {"ROTATION", file.add<std::int8_t>({0, 127, 0, 0}, 5120, "VEC4", 1, {{"normalized", true}})}};
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->instances[0].world_from_mesh.apply(Vec3d{1, 0, 0}), (Vec3d{99, 0, 0}));
}

TEST(Instancing, refuses_counts_and_types_that_do_not_fit) {
  TinyFile file = placed_three_times();
  attributes(file)["SCALE"] = file.add<float>({1, 1, 1}, 5126, "VEC3", 1);
  EXPECT_EQ(file.code(), "GLTF_INSTANCING_INVALID");
  file = placed_three_times();
  attributes(file)["TRANSLATION"] = 1;
  EXPECT_EQ(file.code(), "GLTF_INSTANCING_INVALID");
  file = placed_three_times();
  attributes(file) = json::object();
  EXPECT_EQ(file.code(), "GLTF_INSTANCING_INVALID");
}

TEST(Instancing, refuses_transforms_that_are_not_finite) {
  TinyFile file = placed_three_times();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  attributes(file)["SCALE"] = file.add<float>({1, 1, 1, 1, nan, 1, 1, 1, 1}, 5126, "VEC3", 3);
  EXPECT_EQ(file.code(), "GLTF_TRANSFORM_INVALID");
  file = placed_three_times();
  attributes(file)["ROTATION"] =
      file.add<float>({0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1}, 5126, "VEC4", 3);
  EXPECT_EQ(file.code(), "GLTF_TRANSFORM_INVALID");
}

TEST(Instancing, is_bounded_over_all_nodes) {
  TinyFile file = placed_three_times();
  const json node = file.root["nodes"][0];
  file.root["nodes"].push_back(node);
  file.root["scenes"][0]["nodes"] = {0, 1};
  ImportOptions options;
  options.limits.instances = 6;
  EXPECT_EQ(file.code(options), "");
  options.limits.instances = 5;
  EXPECT_EQ(file.code(options), "GLTF_LIMIT_INSTANCES");
  options.limits.instances = 0;
  EXPECT_EQ(one_triangle().code(options), "GLTF_LIMIT_INSTANCES");
}

}  // namespace
}  // namespace sightline
