#include "core/scene/overflow_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/demo/demo.h"
#include "core/import/import.h"

namespace sightline {
namespace {

TEST(MoveGeometry, copies_each_column_once) {
  const auto whole = *import_bytes(demo::write_glb(demo::terrain(3000)), {});
  SceneDescription scene = whole;
  const auto overflow = scene.overflow = OverflowMemory::make(testing::TempDir(), 1ull << 30);
  EXPECT_EQ(overflow_bytes(scene), 0u);
  ASSERT_TRUE(move_geometry(scene));
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < whole.meshes.size(); ++i) {
    const Mesh& before = *whole.meshes[i];
    const Mesh& after = *scene.meshes[i];
    EXPECT_TRUE(overflow->contains(after.positions.data()));
    EXPECT_TRUE(std::ranges::equal(after.positions, before.positions, [](Vec3f a, Vec3f b) {
      return a.x == b.x && a.y == b.y && a.z == b.z;
    }));
    EXPECT_TRUE(IndexView(after.indices) == IndexView(before.indices));
    EXPECT_EQ(after.primitives.size(), before.primitives.size());
    bytes += before.positions.size() * sizeof(Vec3f) + before.indices.listed().size_bytes();
  }
  EXPECT_EQ(overflow_bytes(scene), bytes);
  const auto mesh = scene.meshes.front();
  ASSERT_TRUE(move_geometry(scene));
  EXPECT_EQ(scene.meshes.front(), mesh);
  EXPECT_EQ(overflow_bytes(scene), bytes);
}

TEST(MoveGeometry, says_when_there_is_no_room) {
  auto scene = *import_bytes(demo::write_glb(demo::terrain(3000)), {});
  scene.overflow = OverflowMemory::make(testing::TempDir(), 1000);
  EXPECT_EQ(move_geometry(scene).error().code, "OVERFLOW_FULL");
}

}  // namespace
}  // namespace sightline
