#include "server/service/hit_terms.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

/// Two placements of one mesh of two primitives: file primitives 1 (two triangles) and 4 (one).
std::shared_ptr<const Scene> sample() {
  auto mesh = std::make_shared<Mesh>();
  mesh->name = "chair";
  mesh->file_mesh = 5;
  mesh->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh->indices = {0, 1, 2, 0, 1, 3, 0, 2, 3};
  mesh->primitives = {{0, 2, 1, kNone}, {2, 1, 4, 1}};
  SceneDescription description;
  description.meshes = {mesh};
  description.nodes = {{"room", 2, 0xffffffffu, {}}, {"", 7, 0, {}}};
  description.instances = {{0, 0, {}}, {0, 1, {}}};
  description.materials = {{"wood", false}, {"cloth", true}};
  auto scene = Scene::build(std::move(description));
  return scene ? *scene : nullptr;
}

TEST(HitTerms, names_hits_as_the_file_does) {
  HitBatch hits;
  hits.resize(3);
  hits.instance = {0, kNone, 1};
  hits.triangle = {1, kNone, 2};
  FieldSet all;
  for (const HitField field : all_hit_fields()) all.add(field);
  const auto scene = sample();
  const HitTerms terms = hit_terms(*scene, hits, all);
  EXPECT_EQ(terms.node_name, (std::vector<std::string_view>{"room", "", ""}));
  EXPECT_EQ(terms.node, (Column<std::uint32_t>{2, kNone, 7}));
  EXPECT_EQ(terms.node_path, (std::vector<std::string_view>{"/room", "", "/room/#7"}));
  EXPECT_EQ(terms.mesh_name, (std::vector<std::string_view>{"chair", "", "chair"}));
  EXPECT_EQ(terms.mesh, (Column<std::uint32_t>{5, kNone, 5}));
  EXPECT_EQ(terms.primitive, (Column<std::uint32_t>{1, kNone, 4}));
  EXPECT_EQ(terms.triangle, (Column<std::uint32_t>{1, kNone, 0}));
  EXPECT_EQ(terms.material, (Column<std::uint32_t>{kNone, kNone, 1}));
  EXPECT_EQ(terms.material_name, (std::vector<std::string_view>{"", "", "cloth"}));
}

TEST(HitTerms, number_the_instances_of_each_node) {
  SceneDescription description = sample()->description();
  // Three placements of the second node, then a node with one.
  description.nodes.push_back({"last", 9, 0, {}});
  description.instances = {{0, 0, {}}, {0, 1, {}}, {0, 1, {}}, {0, 1, {}}, {0, 2, {}}};
  const auto scene = Scene::build(std::move(description));
  ASSERT_TRUE(scene);
  HitBatch hits;
  hits.resize(6);
  hits.instance = {3, 0, kNone, 1, 4, 2};
  hits.triangle = {0, 0, kNone, 0, 0, 0};
  const HitTerms terms = hit_terms(**scene, hits, {HitField::kNodeInstance});
  EXPECT_EQ(terms.node_instance, (Column<std::uint32_t>{2, 0, kNone, 0, 0, 1}));
}

TEST(HitTerms, keep_the_end_of_a_long_path) {
  SceneDescription description = sample()->description();
  for (std::uint32_t i = 2; i < 2000; ++i) {
    description.nodes.push_back({"node " + std::to_string(i), i, i - 1, {}});
  }
  description.instances.push_back({0, 1999, {}});
  const auto scene = Scene::build(std::move(description));
  ASSERT_TRUE(scene);
  HitBatch hits;
  hits.resize(1);
  hits.instance = {2};
  hits.triangle = {0};
  const HitTerms terms = hit_terms(**scene, hits, {HitField::kNodePath});
  EXPECT_TRUE(terms.node_path[0].starts_with(".../node "));
  EXPECT_TRUE(terms.node_path[0].ends_with("/node 1998/node 1999"));
  EXPECT_LT(terms.node_path[0].size(), 4200u);
}

TEST(HitTerms, fills_nothing_that_was_not_asked_for) {
  HitBatch hits;
  hits.resize(1);
  hits.instance = {0};
  hits.triangle = {0};
  const auto scene = sample();
  const HitTerms terms = hit_terms(*scene, hits, {HitField::kT, HitField::kMesh});
  EXPECT_EQ(terms.mesh_name.size(), 1u);
  EXPECT_TRUE(terms.mesh.empty() && terms.node.empty() && terms.node_name.empty());
  EXPECT_TRUE(terms.primitive.empty() && terms.triangle.empty() && terms.material.empty());
}

}  // namespace
}  // namespace sightline
