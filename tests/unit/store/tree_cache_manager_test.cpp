// Trees ahead of rays, between two runs, and within a budget.

#include "core/store/tree_cache_manager.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "core/demo/demo.h"
#include "core/import/import.h"

namespace sightline {
namespace {

std::shared_ptr<const Scene> terrain(std::uint64_t seed) {
  return *Scene::prepare(*import_bytes(demo::write_glb(demo::terrain(3000, seed)), {}));
}

class TreeCacheManagerFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() / ("sightline_trees_" + std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  TreeCacheOptions options() {
    TreeCacheOptions options;
    options.folder = folder_;
    options.report = [this](const std::string& line) { lines_.push_back(line); };
    return options;
  }
  TreeStats kept(const std::shared_ptr<const Scene>& scene) {
    TreeCacheManager manager(options());
    EXPECT_TRUE(manager.adopt(scene));
    manager.wait_until_idle();
    return scene->trees().stats();
  }
  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      found.push_back(entry.path());
    return found;
  }

  std::filesystem::path folder_;
  std::vector<std::string> lines_;
};

TEST_F(TreeCacheManagerFolder, builds_once_and_reads_in_the_next_run) {
  TreeStats stats = kept(terrain(1));
  EXPECT_EQ(stats.full_builds, 1u);
  EXPECT_EQ(stats.cache_hits, 0u);
  ASSERT_EQ(files().size(), 1u);
  stats = kept(terrain(1));
  EXPECT_EQ(stats.full_builds, 0u);
  EXPECT_EQ(stats.cache_hits, 1u);
  EXPECT_TRUE(stats.complete);
  EXPECT_TRUE(lines_.empty());
}

TEST_F(TreeCacheManagerFolder, builds_again_what_was_damaged_and_says_so) {
  kept(terrain(1));
  ASSERT_EQ(files().size(), 1u);
  {
    std::fstream file(files()[0], std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-5, std::ios::end);
    file.put('!');
  }
  TreeStats stats = kept(terrain(1));
  EXPECT_EQ(stats.cache_rejects, 1u);
  EXPECT_EQ(stats.full_builds, 1u);
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_NE(lines_[0].find("TREES_DAMAGED"), std::string::npos);
  // The file that took its place is good.
  EXPECT_EQ(kept(terrain(1)).cache_hits, 1u);
}

TEST_F(TreeCacheManagerFolder, is_not_led_astray_by_what_a_stopped_run_left) {
  std::filesystem::create_directories(folder_);
  std::ofstream(folder_ / "writing") << "half";
  EXPECT_EQ(kept(terrain(1)).full_builds, 1u);
  EXPECT_EQ(kept(terrain(1)).cache_hits, 1u);
  EXPECT_EQ(files().size(), 1u);
}

TEST_F(TreeCacheManagerFolder, throws_out_the_oldest_files_for_want_of_room) {
  TreeFolder folder(folder_, 700000);
  std::vector<std::uint64_t> used;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto scene = terrain(seed);
    ASSERT_TRUE(folder.write(*build_scene_tree(scene->trees().plan()), seed, {}));
    std::filesystem::last_write_time(files().back(), std::filesystem::file_time_type::clock::now());
  }
  std::uint64_t sum = 0;
  for (const auto& file : files()) sum += std::filesystem::file_size(file);
  EXPECT_LE(sum, 700000u);
  EXPECT_GE(files().size(), 2u);
}

TEST(TreeCacheManager, builds_ahead_and_forgets_scenes_that_are_gone) {
  TreeCacheManager manager({});
  auto scene = terrain(1);
  ASSERT_TRUE(manager.adopt(scene));
  manager.wait_until_idle();
  EXPECT_TRUE(scene->tree()->complete());
  EXPECT_EQ(scene.use_count(), 1);
  scene.reset();
  manager.wait_until_idle();
}

TEST(TreeCacheManager, builds_nothing_ahead_when_it_is_told_so) {
  TreeCacheOptions options;
  options.ahead = false;
  TreeCacheManager manager(options);
  const auto scene = terrain(1);
  ASSERT_TRUE(manager.adopt(scene));
  manager.wait_until_idle();
  EXPECT_FALSE(scene->tree()->complete());
}

TEST(TreeCacheManager, breaks_off_what_it_builds) {
  const auto scene =
      *Scene::prepare(*import_bytes(demo::write_glb(demo::terrain(2'000'000, 1)), {}));
  {
    TreeCacheManager manager({});
    ASSERT_TRUE(manager.adopt(scene));
    // Its head start, and the first steps.
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  EXPECT_FALSE(scene->tree()->complete());
  EXPECT_EQ(scene->trees().stats().full_builds, 0u);
}

TEST(TreeCacheManager, breaks_off_what_it_builds_for_a_scene_that_is_gone) {
  TreeCacheManager manager({});
  auto scene = *Scene::prepare(*import_bytes(demo::write_glb(demo::terrain(2'000'000, 1)), {}));
  const std::weak_ptr<const Scene> gone = scene;
  ASSERT_TRUE(manager.adopt(scene));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  scene.reset();
  manager.wait_until_idle();
  EXPECT_TRUE(gone.expired());
  EXPECT_EQ(manager.totals().full_builds, 0u);
}

TEST(TreeCacheManager, stays_within_its_budget) {
  const auto first = terrain(1), second = terrain(2);
  TreeCacheOptions options;
  const std::uint64_t one = first->trees().held_geometry_bytes() + first->trees().full_tree_bytes();
  options.memory_budget = one + second->trees().held_geometry_bytes() + 100000;
  TreeCacheManager manager(options);
  ASSERT_TRUE(manager.adopt(first));
  manager.wait_until_idle();
  ASSERT_TRUE(manager.adopt(second));
  manager.wait_until_idle();
  EXPECT_TRUE(first->tree()->complete());
  EXPECT_FALSE(second->tree()->complete());
  const auto third = terrain(3);
  EXPECT_EQ(manager.adopt(*Scene::prepare(*import_bytes(demo::write_glb(demo::terrain(60000)), {})))
                .error()
                .code,
            "SCENE_OVER_BUDGET");
}

}  // namespace
}  // namespace sightline
