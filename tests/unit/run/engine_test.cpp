#include "core/run/engine.h"

#include <gtest/gtest.h>

#include "core/demo/demo.h"
#include "core/import/import.h"

namespace sightline {
namespace {

class EngineTest : public testing::Test {
 protected:
  void SetUp() override {
    auto description = import_bytes(demo::write_glb(demo::six_triangles()), {});
    ASSERT_TRUE(description.ok());
    scene_ = *Scene::build(std::move(*description));
    auto engine = Engine::create({.threads = 2, .kernel = ""});
    ASSERT_TRUE(engine.ok());
    engine_ = std::move(*engine);
  }
  /// Rays that meet all six triangles, every third one none.
  static RayBatch rays(std::size_t count) {
    RayBatch batch;
    for (std::size_t i = 0; i < count; ++i) {
      batch.push_back({{-10, i % 3 == 2 ? 9.0 : 1.0, 0}, {1, 0, 0}});
    }
    return batch;
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<Engine> engine_;
  Deadline never_ = Deadline::never();
};

TEST_F(EngineTest, answers_no_rays) {
  HitBatch hits;
  HitLists lists;
  Column<std::uint8_t> occluded;
  Column<std::uint64_t> totals;
  EXPECT_TRUE(engine_->closest(*scene_, {}, never_, hits).ok());
  EXPECT_TRUE(engine_->any(*scene_, {}, never_, occluded).ok());
  EXPECT_TRUE(engine_->count(*scene_, {}, Crossings::kEvery, never_, totals).ok());
  EXPECT_TRUE(engine_->all(*scene_, {}, {Crossings::kEvery, 9, 9}, never_, lists, totals).ok());
  EXPECT_EQ(lists.first, (Column<std::size_t>{0}));
  EXPECT_EQ(lists.hits.size() + totals.size() + hits.size() + occluded.size(), 0u);
}

TEST_F(EngineTest, joins_the_lists_of_many_slices_in_the_order_of_rays) {
  const RayBatch batch = rays(1000);
  HitLists lists;
  Column<std::uint64_t> totals, counts;
  ASSERT_TRUE(
      engine_->all(*scene_, batch, {Crossings::kEvery, 4, 1u << 20}, never_, lists, totals).ok());
  ASSERT_TRUE(engine_->count(*scene_, batch, Crossings::kEvery, never_, counts).ok());
  EXPECT_EQ(totals, counts);
  ASSERT_EQ(lists.first.size(), 1001u);
  ASSERT_EQ(lists.first.back(), lists.hits.size());
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const bool none = i % 3 == 2;
    ASSERT_EQ(totals[i], none ? 0u : 6u);
    ASSERT_EQ(lists.first[i + 1] - lists.first[i], none ? 0u : 4u);
    if (!none) {
      ASSERT_EQ(lists.hits.t[lists.first[i]], 4.5);
      ASSERT_EQ(lists.hits.t[lists.first[i] + 3], 12.5);
    }
  }
}

TEST_F(EngineTest, refuses_more_hits_than_allowed_together) {
  HitLists lists;
  Column<std::uint64_t> totals;
  const RayBatch batch = rays(900);  // 600 of them meet 6
  EXPECT_TRUE(
      engine_->all(*scene_, batch, {Crossings::kEvery, 6, 3600}, never_, lists, totals).ok());
  const Status refused =
      engine_->all(*scene_, batch, {Crossings::kEvery, 6, 3599}, never_, lists, totals);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, "TOO_MANY_HITS");
  EXPECT_TRUE(
      engine_->all(*scene_, batch, {Crossings::kEvery, 5, 3000}, never_, lists, totals).ok());
}

}  // namespace
}  // namespace sightline
