#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/import/import.h"
#include "tests/support/data_folder.h"

// features.glb has one feature per node. Here a few of them are computed a second time, from the
// file's bytes and by other code.

namespace sightline {
namespace {

/// The file by a reader that only knows tightly packed float32 positions.
class PlainReader {
 public:
  explicit PlainReader(const std::vector<std::byte>& file) {
    std::uint32_t json_bytes = 0;
    std::memcpy(&json_bytes, file.data() + 12, 4);
    const char* text = reinterpret_cast<const char*>(file.data()) + 20;
    json = nlohmann::json::parse(text, text + json_bytes);
    binary = file.data() + 20 + json_bytes + 8;
  }

  std::vector<Vec3d> positions(const nlohmann::json& accessor_index) const {
    const auto& accessor = json["accessors"][accessor_index.get<std::size_t>()];
    const auto& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::byte* at = binary + view.value("byteOffset", 0) + accessor.value("byteOffset", 0);
    std::vector<Vec3d> out(accessor["count"].get<std::size_t>());
    for (Vec3d& p : out) {
      float xyz[3];
      std::memcpy(xyz, at, sizeof xyz);
      p = {static_cast<double>(xyz[0]), static_cast<double>(xyz[1]), static_cast<double>(xyz[2])};
      at += sizeof xyz;
    }
    return out;
  }

  const nlohmann::json& node(const std::string& name) const {
    return *std::find_if(json["nodes"].begin(), json["nodes"].end(),
                         [&](const auto& n) { return n["name"] == name; });
  }

  nlohmann::json json;
  const std::byte* binary = nullptr;
};

class FeaturesFile : public ::testing::Test {
 protected:
  void SetUp() override {
    auto imported = import_file(test::test_data("scenes/features.glb"), {});
    ASSERT_TRUE(imported.ok()) << imported.error().message;
    scene = *std::move(imported);
  }

  const Instance* instance_of(const std::string& name) const {
    for (const Instance& instance : scene.instances) {
      if (scene.nodes[instance.node].name == name) return &instance;
    }
    return nullptr;
  }
  const Mesh& mesh_of(const std::string& name) const {
    return *scene.meshes[instance_of(name)->mesh];
  }

  const std::vector<std::byte> bytes = test::read_bytes(test::test_data("scenes/features.glb"));
  const PlainReader plain{bytes};
  SceneDescription scene;
};

TEST_F(FeaturesFile, keeps_the_shear_of_a_node_matrix) {
  const auto& node = plain.node("matrix_shear_mirror");
  const auto m = node["matrix"].get<std::vector<double>>();
  const auto& primitive = plain.json["meshes"][node["mesh"].get<std::size_t>()]["primitives"][0];
  double lowest = 1e300;
  for (const Vec3d& p : plain.positions(primitive["attributes"]["POSITION"])) {
    lowest = std::min(lowest, ((m[1] * p.x + m[5] * p.y) + m[9] * p.z) + m[13]);
  }
  const Instance* instance = instance_of("matrix_shear_mirror");
  ASSERT_NE(instance, nullptr);
  double ours = 1e300;
  for (const Vec3f& p : scene.meshes[instance->mesh]->positions) {
    ours = std::min(ours, instance->world_from_mesh.apply(p).y);
  }
  EXPECT_EQ(ours, lowest);
  EXPECT_NEAR(ours, -0.74849697, 1e-8);
}

TEST_F(FeaturesFile, applies_the_default_weights_of_a_morphed_mesh) {
  const auto& node = plain.node("morph_weight_1_lifts_by_1");
  const auto& mesh = plain.json["meshes"][node["mesh"].get<std::size_t>()];
  const auto& primitive = mesh["primitives"][0];
  const auto base = plain.positions(primitive["attributes"]["POSITION"]);
  const auto delta = plain.positions(primitive["targets"][0]["POSITION"]);
  const double weight = mesh["weights"][0].get<double>();
  const Mesh& ours = mesh_of("morph_weight_1_lifts_by_1");
  ASSERT_EQ(ours.positions.size(), base.size());
  for (std::size_t i = 0; i < base.size(); ++i) {
    const Vec3f wanted = {static_cast<float>(base[i].x + weight * delta[i].x),
                          static_cast<float>(base[i].y + weight * delta[i].y),
                          static_cast<float>(base[i].z + weight * delta[i].z)};
    EXPECT_EQ(ours.positions[i], wanted) << "vertex " << i;
  }
}

TEST_F(FeaturesFile, counts_what_is_not_made_of_triangles) {
  EXPECT_EQ(scene.counts.skipped_primitives, 6u);
  for (const char* name : {"points", "lines", "line_loop", "line_strip", "no_POSITION"}) {
    EXPECT_EQ(instance_of(name), nullptr) << name;
  }
  const Mesh& two = mesh_of("two_prims_tri_and_lines");
  ASSERT_EQ(two.primitives.size(), 1u);
  EXPECT_EQ(two.primitives[0].file_primitive, 0u);
}

TEST_F(FeaturesFile, walks_the_chain_of_twelve) {
  const Instance* last = instance_of("chain11");
  ASSERT_NE(last, nullptr);
  std::uint32_t depth = 0;
  for (std::uint32_t n = last->node; n != 0xffffffffu; n = scene.nodes[n].parent) ++depth;
  EXPECT_EQ(depth, 12u);
}

TEST_F(FeaturesFile, is_the_same_scene_with_external_and_embedded_buffers) {
  for (const char* name : {"features_datauri.gltf", "features_external.gltf"}) {
    const auto other = import_file(test::test_data(std::filesystem::path("scenes") / name), {});
    ASSERT_TRUE(other.ok()) << name << ": " << other.error().message;
    ASSERT_EQ(other->instances.size(), scene.instances.size());
    ASSERT_EQ(other->meshes.size(), scene.meshes.size());
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
      EXPECT_EQ(other->instances[i].world_from_mesh, scene.instances[i].world_from_mesh);
      EXPECT_EQ(other->instances[i].mesh, scene.instances[i].mesh);
    }
    for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
      EXPECT_EQ(other->meshes[i]->positions, scene.meshes[i]->positions);
      EXPECT_EQ(other->meshes[i]->indices, scene.meshes[i]->indices);
    }
  }
}

TEST_F(FeaturesFile, shares_a_mesh_between_its_nodes_and_leaves_out_the_others) {
  EXPECT_EQ(instance_of("tri_u8")->mesh, instance_of("far_away")->mesh);
  EXPECT_LT(scene.meshes.size(), plain.json["meshes"].size());
  EXPECT_EQ(instance_of("only_in_scene0"), nullptr);
}

TEST_F(FeaturesFile, states_how_much_of_it_was_read) {
  EXPECT_EQ(scene.counts.file_bytes, bytes.size());
  EXPECT_LT(scene.counts.bytes_touched, bytes.size());
  EXPECT_GT(scene.counts.bytes_touched, bytes.size() / 2);
}

}  // namespace
}  // namespace sightline
