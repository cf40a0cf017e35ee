#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <tuple>

#include "core/demo/demo.h"

namespace sightline::demo {
namespace {

std::uint32_t u32_at(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

nlohmann::json json_of(const std::vector<std::byte>& glb) {
  const char* text = reinterpret_cast<const char*>(glb.data()) + 20;
  return nlohmann::json::parse(text, text + u32_at(glb, 12));
}

DemoScene one_triangle() {
  DemoScene scene;
  scene.name = "a \"quoted\" name";
  scene.meshes.push_back({"mesh", "paint", {0, 0, 0, 1, 0, 0, 0, 0.1f, -2}, {0, 1, 2}});
  scene.nodes.push_back({"parent", -1, -1, {}});
  scene.nodes.push_back({"child", 0, 0, {}});
  scene.nodes[1].parent_from_node.m[1][3] = 7;
  return scene;
}

TEST(WriteGlb, has_a_header_and_two_aligned_chunks) {
  const std::vector<std::byte> glb = write_glb(one_triangle());
  ASSERT_GE(glb.size(), 28u);
  EXPECT_EQ(u32_at(glb, 0), 0x46546c67u);
  EXPECT_EQ(u32_at(glb, 4), 2u);
  EXPECT_EQ(u32_at(glb, 8), glb.size());
  EXPECT_EQ(u32_at(glb, 12) % 4, 0u);
  EXPECT_EQ(u32_at(glb, 16), 0x4e4f534au);
  const std::size_t bin = 20 + u32_at(glb, 12);
  EXPECT_EQ(u32_at(glb, bin), 36u + 8u);
  EXPECT_EQ(u32_at(glb, bin + 4), 0x004e4942u);
  EXPECT_EQ(bin + 8 + u32_at(glb, bin), glb.size());
}

TEST(WriteGlb, writes_names_hierarchy_and_the_matrix_by_columns) {
  const nlohmann::json json = json_of(write_glb(one_triangle()));
  EXPECT_EQ(json["scenes"][0]["name"], "a \"quoted\" name");
  EXPECT_EQ(json["scenes"][0]["nodes"], nlohmann::json::array({0}));
  EXPECT_EQ(json["nodes"][0]["children"], nlohmann::json::array({1}));
  EXPECT_FALSE(json["nodes"][0].contains("matrix"));
  EXPECT_EQ(json["nodes"][1]["matrix"],
            nlohmann::json({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 7, 0, 1}));
  EXPECT_EQ(json["materials"][0]["name"], "paint");
  EXPECT_EQ(json["accessors"][0]["max"][1].get<float>(), 0.1f);
}

TEST(WriteGlb, takes_u32_indices_only_beyond_65535_vertices) {
  DemoScene scene = one_triangle();
  scene.meshes[0].positions.resize(std::size_t{65535} * 3);
  EXPECT_EQ(json_of(write_glb(scene))["accessors"][1]["componentType"], 5123);
  scene.meshes[0].positions.resize(std::size_t{65536} * 3);
  EXPECT_EQ(json_of(write_glb(scene))["accessors"][1]["componentType"], 5125);
}

TEST(WriteGlb, writes_what_is_said_of_each_vertex) {
  const std::vector<std::byte> glb = write_glb(painted_square());
  const nlohmann::json json = json_of(glb);
  const nlohmann::json attributes = json["meshes"][0]["primitives"][0]["attributes"];
  const std::size_t binary = 20 + u32_at(glb, 12) + 8;
  for (const auto& [name, type, last] : {std::tuple{"NORMAL", "VEC3", 0.8f},
                                         {"TEXCOORD_0", "VEC2", 0.0f},
                                         {"COLOR_0", "VEC4", 1.0f}}) {
    const nlohmann::json accessor = json["accessors"][attributes[name].get<std::size_t>()];
    EXPECT_EQ(accessor["type"], type);
    EXPECT_EQ(accessor["count"], 4);
    const nlohmann::json view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::size_t end =
        view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>();
    EXPECT_EQ(std::bit_cast<float>(u32_at(glb, binary + end - 4)), last) << name;
  }
}

TEST(WriteGlb, leaves_out_arrays_that_would_be_empty) {
  const nlohmann::json json = json_of(write_glb(DemoScene{}));
  for (const char* name : {"nodes", "meshes", "accessors", "bufferViews", "buffers", "materials"}) {
    EXPECT_FALSE(json.contains(name)) << name;
  }
}

}  // namespace
}  // namespace sightline::demo
