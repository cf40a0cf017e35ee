#include "core/import/gltf/hierarchy.h"

#include <gtest/gtest.h>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using test::json;
using test::one_triangle;
using test::TinyFile;

TinyFile with_nodes(const json& nodes, const json& roots) {
  TinyFile file = one_triangle();
  file.root["nodes"] = nodes;
  file.root["scenes"][0]["nodes"] = roots;
  return file;
}

TEST(Hierarchy, is_walked_depth_first_in_file_order) {
  const TinyFile file = with_nodes({{{"name", "c"}},
                                    {{"name", "a"}, {"children", {3, 0}}},
                                    {{"name", "d"}},
                                    {{"name", "b"}, {"mesh", 0}}},
                                   {1, 2});
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  std::string names;
  for (const Node& node : scene->nodes) names += node.name;
  EXPECT_EQ(names, "abcd");
  EXPECT_EQ(scene->nodes[1].parent, 0u);
  EXPECT_EQ(scene->nodes[2].parent, 0u);
  EXPECT_EQ(scene->nodes[3].parent, 0xffffffffu);
  EXPECT_EQ(scene->nodes[1].file_node, 3u);
  ASSERT_EQ(scene->instances.size(), 1u);
  EXPECT_EQ(scene->instances[0].node, 1u);
}

TEST(Hierarchy, multiplies_parent_by_child) {
  const TinyFile file = with_nodes(
      {{{"scale", {2, 3, 4}}, {"children", {1}}}, {{"translation", {1, 1, 1}}, {"mesh", 0}}}, {0});
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->instances[0].world_from_mesh.apply(Vec3d{1, 0, 0}), (Vec3d{4, 3, 4}));
}

TEST(Hierarchy, refuses_cycles_two_parents_and_roots_that_are_children) {
  for (const auto& [nodes, roots] : std::vector<std::pair<const char*, const char*>>{
           {R"([{"children":[0]}])", "[0]"},
           {R"([{"children":[1]},{"children":[0]}])", "[0]"},
           {R"([{},{"children":[2]},{"children":[1]}])", "[0]"},
           {R"([{"children":[2]},{"children":[2]},{}])", "[0,1]"},
           {R"([{"children":[1,1]},{}])", "[0]"},
           {R"([{"children":[1]},{}])", "[0,1]"},
           {R"([{"children":[1]},{}])", "[1]"},
           {R"([{}])", "[0,0]"}}) {
    EXPECT_EQ(with_nodes(json::parse(nodes), json::parse(roots)).code(), "GLTF_HIERARCHY_INVALID")
        << nodes << " " << roots;
  }
}

TEST(Hierarchy, is_as_deep_as_its_limit_and_no_deeper) {
  json nodes = json::array();
  for (int i = 0; i < 50; ++i) nodes.push_back({{"children", {i + 1}}});
  nodes.push_back({{"mesh", 0}});
  ImportOptions options;
  options.limits.node_depth = 51;
  EXPECT_EQ(with_nodes(nodes, {0}).code(options), "");
  options.limits.node_depth = 50;
  EXPECT_EQ(with_nodes(nodes, {0}).code(options), "GLTF_LIMIT_NODE_DEPTH");
}

TEST(Hierarchy, of_a_hundred_thousand_levels_needs_no_stack) {
  json nodes = json::array();
  for (int i = 0; i < 100000; ++i) nodes.push_back({{"children", {i + 1}}});
  nodes.push_back({{"mesh", 0}});
  ImportOptions options;
  options.limits.node_depth = 200000;
  EXPECT_EQ(with_nodes(nodes, {0}).code(options), "");
}

TEST(Hierarchy, bounds_the_number_of_nodes) {
  ImportOptions options;
  options.limits.nodes = 1;
  EXPECT_EQ(with_nodes(json::array({json::object()}), {0}).code(options), "");
  EXPECT_EQ(with_nodes(json::parse("[{},{}]"), {0}).code(options), "GLTF_LIMIT_NODES");
}

TEST(Hierarchy, refuses_matrices_whose_product_leaves_the_range) {
  const json large = {{"scale", {1e30, 1, 1}}, {"children", {1}}};
  const json child = {{"scale", {1e30, 1, 1}}, {"mesh", 0}};
  EXPECT_EQ(with_nodes({large, child}, {0}).code(), "GLTF_TRANSFORM_INVALID");
}

TEST(Scenes, are_chosen_by_the_caller_then_by_the_file_then_by_order) {
  TinyFile file = with_nodes({{{"name", "first"}}, {{"name", "second"}}, {{"name", "third"}}}, {0});
  file.root["scenes"] = {
      {{"name", "A"}, {"nodes", {0}}}, {{"name", "B"}, {"nodes", {1}}}, {{"name", "C"}}};
  file.root["scene"] = 1;
  EXPECT_EQ(file.import()->name, "B");
  EXPECT_EQ(file.import()->nodes[0].name, "second");
  ImportOptions options;
  options.scene = 0;
  EXPECT_EQ(file.import(options)->name, "A");
  options.scene = 2;
  EXPECT_TRUE(file.import(options)->nodes.empty());
  options.scene = 3;
  EXPECT_EQ(file.code(options), "GLTF_SCENE_UNKNOWN");
  file.root.erase("scene");
  EXPECT_EQ(file.import()->name, "A");
}

TEST(Scenes, that_are_absent_mean_every_root_and_a_warning) {
  TinyFile file =
      with_nodes({{{"name", "a"}, {"children", {2}}}, {{"name", "b"}}, {{"name", "c"}}}, {0});
  file.root.erase("scene");
  file.root.erase("scenes");
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  std::string names;
  for (const Node& node : scene->nodes) names += node.name;
  EXPECT_EQ(names, "acb");
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_NE(scene->warnings[0].find("no scenes"), std::string::npos);
}

}  // namespace
}  // namespace sightline
