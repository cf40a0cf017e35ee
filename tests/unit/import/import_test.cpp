#include "core/import/import.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/demo/demo.h"
#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using test::json;
using test::one_triangle;
using test::TinyFile;

TEST(Import, gives_back_the_demo_town) {
  const demo::DemoScene town = demo::town();
  const auto scene = import_bytes(demo::write_glb(town), {});
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->name, "town");
  EXPECT_TRUE(scene->warnings.empty());
  ASSERT_EQ(scene->nodes.size(), town.nodes.size());
  ASSERT_EQ(scene->meshes.size(), town.meshes.size());
  // Nodes come in the order of the walk, meshes in the order in which nodes show them.
  for (const Node& node : scene->nodes) {
    const auto& source = town.nodes[node.file_node];
    EXPECT_EQ(node.name, source.name);
    Affine world = source.parent_from_node;
    for (int p = source.parent; p >= 0; p = town.nodes[static_cast<std::size_t>(p)].parent) {
      world = town.nodes[static_cast<std::size_t>(p)].parent_from_node * world;
    }
    EXPECT_EQ(node.world_from_node, world) << node.name;
  }
  for (const auto& mesh : scene->meshes) {
    const auto& source = town.meshes[mesh->file_mesh];
    EXPECT_EQ(mesh->name, source.name);
    EXPECT_TRUE(std::equal(mesh->indices.begin(), mesh->indices.end(), source.indices.begin(),
                           source.indices.end()));
    ASSERT_EQ(mesh->positions.size() * 3, source.positions.size());
    EXPECT_EQ(mesh->positions.end()[-1].z, source.positions.back());
    EXPECT_EQ(scene->materials[mesh->primitives[0].material].name, source.material);
  }
}

TEST(Import, never_warns_without_end) {
  TinyFile file = one_triangle();
  file.root["nodes"] = json::array();
  file.root["scenes"][0]["nodes"] = json::array();
  for (int i = 0; i < 5000; ++i) {
    file.root["nodes"].push_back({{"skin", 0}, {"mesh", 0}});
    file.root["scenes"][0]["nodes"].push_back(i);
  }
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->warnings.size(), 101u);
  EXPECT_EQ(scene->warnings.back(), "and 4900 more warnings");
}

TEST(Import, counts_the_bytes_that_it_read) {
  TinyFile file = one_triangle();
  file.add_view<float>(std::vector<float>(1000));
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  const std::size_t text = file.bytes().size() - file.binary.size() - 28;
  EXPECT_EQ(scene->counts.file_bytes, file.bytes().size());
  EXPECT_EQ(scene->counts.bytes_touched, text + 36 + 6);
}

TEST(Import, leaves_out_meshes_without_triangles) {
  TinyFile file = one_triangle();
  file.root["meshes"][0]["primitives"][0]["mode"] = 0;
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  EXPECT_TRUE(scene->meshes.empty());
  EXPECT_TRUE(scene->instances.empty());
  EXPECT_EQ(scene->nodes.size(), 1u);
  EXPECT_EQ(scene->counts.skipped_primitives, 1u);
}

TEST(Import, bounds_the_file) {
  ImportOptions options;
  options.limits.file_bytes = 100;
  EXPECT_EQ(one_triangle().code(options), "GLTF_LIMIT_FILE_BYTES");
}

TEST(Import, names_an_absent_file_without_its_folder) {
  const auto scene = import_file("/nonexistent/folder/a.glb", {});
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().kind, ErrorKind::kNotFound);
  EXPECT_EQ(scene.error().message, "\"a.glb\": cannot be opened");
}

TEST(Import, answers_every_truncated_length_and_every_changed_byte_of_a_small_file) {
  const std::vector<std::byte> good = one_triangle().bytes();
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(import_bytes(std::span(good).first(size), {}).ok()) << size;
  }
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const unsigned value : {0u, 0xffu, 0x22u, 0x39u, 0x7bu}) {
      std::vector<std::byte> changed = good;
      changed[at] = static_cast<std::byte>(value);
      const auto scene = import_bytes(changed, {});
      if (!scene) {
        EXPECT_NE(scene.error().code, "GLTF_INTERNAL") << at << " to " << value;
      }
    }
  }
}

}  // namespace
}  // namespace sightline
