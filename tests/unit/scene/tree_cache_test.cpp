// Trees as bytes: what was written comes back, and nothing else does.

#include "core/scene/tree_cache.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/base/column.h"
#include "core/scene/tree_cache_format.h"
#include "tests/unit/scene/small_scenes.h"

namespace sightline {
namespace {

using test::description_of;

using Bytes = Column<std::byte>;

Bytes bytes_of(const Scene& scene) {
  const EncodedTrees encoded = encode_trees(*scene.tree(), content_hash(scene.trees().plan()));
  Bytes bytes(encoded.head.begin(), encoded.head.end());
  for (const auto& arena : encoded.arenas) bytes.insert(bytes.end(), arena.begin(), arena.end());
  return bytes;
}

Result<SceneTree> decode(const Scene& scene, const Bytes& bytes) {
  const ScenePlan& plan = scene.trees().plan();
  return decode_trees(plan, content_hash(plan), bytes, std::make_shared<int>());
}

std::string code_of(const Result<SceneTree>& tree) { return tree ? "" : tree.error().code; }

TEST(TreeCache, gives_back_what_was_written) {
  for (const auto& make : {+[] { return demo::town(); }, +[] { return test::three_sizes(); },
                           +[] { return demo::instances(600, 3000); }}) {
    const auto scene = *Scene::build(description_of(make()));
    const auto built = scene->tree();
    const Bytes bytes = bytes_of(*scene);
    const auto read = decode(*scene, bytes);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->trees.size(), built->trees.size());
    EXPECT_EQ(read->entries, built->entries);
    EXPECT_EQ(read->placements.size(), built->placements.size());
    EXPECT_EQ(read->depth, built->depth);
    EXPECT_EQ(read->bounds, built->bounds);
    for (std::size_t i = 0; i < read->trees.size(); ++i) {
      const Arena& a = read->trees[i]->arena;
      const Arena& b = built->trees[i]->arena;
      ASSERT_EQ(a.used(), b.used());
      EXPECT_EQ(std::memcmp(a.at(0), b.at(0), a.used()), 0);
      EXPECT_GE(a.at(0), bytes.data());  // not copied
    }
  }
}

TEST(TreeCache, holds_the_same_trees_whether_indices_are_listed_or_not) {
  SceneDescription description = description_of(demo::soup(2000));
  SceneDescription listed = description;
  auto mesh = std::make_shared<Mesh>(*description.meshes[0]);
  ASSERT_TRUE(mesh->indices.listed().empty());
  mesh->indices.own();
  ASSERT_EQ(mesh->indices.listed().size(), 6000u);
  listed.meshes[0] = mesh;
  const auto scene = *Scene::build(std::move(description));
  const auto other = *Scene::build(std::move(listed));
  EXPECT_EQ(other->trees().held_geometry_bytes() - scene->trees().held_geometry_bytes(), 24000u);
  const Bytes bytes = bytes_of(*scene);  // which the trees lie in
  const auto read = decode(*scene, bytes);
  ASSERT_TRUE(read) << read.error().message;
  const Arena &a = read->trees[0]->arena, &b = other->tree()->trees[0]->arena;
  ASSERT_EQ(a.used(), b.used());
  EXPECT_EQ(std::memcmp(a.at(0), b.at(0), a.used()), 0);
}

TEST(TreeCache, refuses_every_truncated_length) {
  const auto scene = *Scene::build(description_of(test::three_sizes()));
  const Bytes whole = bytes_of(*scene);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_FALSE(decode(*scene, part)) << size;
  }
}

TEST(TreeCache, refuses_every_byte_that_was_changed) {
  const auto scene = *Scene::build(description_of(test::three_sizes()));
  Bytes bytes = bytes_of(*scene);
  for (std::byte& byte : bytes) {
    byte ^= std::byte{0x10};
    ASSERT_FALSE(decode(*scene, bytes));
    byte ^= std::byte{0x10};
  }
  EXPECT_TRUE(decode(*scene, bytes));
}

TEST(TreeCache, says_whether_a_file_is_foreign_stale_or_damaged) {
  const auto scene = *Scene::build(description_of(demo::six_triangles()));
  const auto other = *Scene::build(description_of(demo::terrain(100)));
  Bytes bytes = bytes_of(*scene);
  EXPECT_EQ(code_of(decode(*other, bytes)), "TREES_STALE");
  EXPECT_EQ(code_of(decode(*scene, Bytes(4096, std::byte{'x'}))), "TREES_FOREIGN");
  EXPECT_EQ(code_of(decode(*scene, {})), "TREES_FOREIGN");
  bytes.back() ^= std::byte{1};
  EXPECT_EQ(code_of(decode(*scene, bytes)), "TREES_DAMAGED");

  tree_cache::Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  ++header.version;
  header.hash = tree_cache::hash_of(header);
  std::memcpy(bytes.data(), &header, sizeof header);
  EXPECT_EQ(code_of(decode(*scene, bytes)), "TREES_STALE");
}

TEST(TreeCache, refuses_trees_of_another_scene_under_the_same_name) {
  const auto scene = *Scene::build(description_of(demo::terrain(200, 1)));
  const auto other = *Scene::build(description_of(demo::terrain(200, 2)));
  const EncodedTrees forged = encode_trees(*other->tree(), content_hash(scene->trees().plan()));
  Bytes bytes(forged.head.begin(), forged.head.end());
  for (const auto& arena : forged.arenas) bytes.insert(bytes.end(), arena.begin(), arena.end());
  EXPECT_EQ(code_of(decode(*scene, bytes)), "TREES_DAMAGED");
}

TEST(TreeCache, tells_contents_apart) {
  const auto hash = [](const demo::DemoScene& scene) {
    return content_hash((*Scene::prepare(description_of(scene)))->trees().plan());
  };
  demo::DemoScene moved = demo::six_triangles();
  moved.nodes.back().parent_from_node.m[0][3] += 0.5;
  EXPECT_EQ(hash(demo::six_triangles()), hash(demo::six_triangles()));
  EXPECT_NE(hash(demo::six_triangles()), hash(moved));
  EXPECT_NE(hash(demo::terrain(200, 1)), hash(demo::terrain(200, 2)));
}

}  // namespace
}  // namespace sightline
