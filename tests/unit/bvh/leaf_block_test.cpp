// What is packed into a leaf block comes out again.

#include "core/bvh/leaf_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sightline {
namespace {

using Named = std::array<std::uint32_t, kLanes>;

void expect_names(const Named& named, std::uint32_t count, std::uint32_t placement) {
  LeafBlock block{};
  block.set_edge_max(1.5f);
  block.set_names(named, count, placement);
  EXPECT_EQ(block.triangles(), named) << placement;
  EXPECT_EQ(block.lane_count(), count);
  EXPECT_EQ(block.placement(), placement);
  EXPECT_EQ(block.edge_max(), 1.5f);
}

TEST(LeafBlock, names_triangles_of_placement_0_in_any_order) {
  constexpr std::uint32_t kLast = 0xffffffffu;
  constexpr std::uint32_t kWide = LeafBlock::kNear - 1;
  for (const std::uint32_t least : {0u, 1u, 0x7fffffffu, kLast - kWide}) {
    expect_names({least, least, least, least}, 1, 0);
    expect_names({least + kWide, least, least + kWide, least}, 4, 0);
    expect_names({least, least + kWide, least, least + kWide}, 4, 0);
    expect_names({least + 3, least + 1, least + 4, least + 1'592'653}, 4, 0);
  }
  EXPECT_TRUE(LeafBlock::fit(5, 5 + kWide, 0));
  EXPECT_FALSE(LeafBlock::fit(5, 6 + kWide, 0));
}

TEST(LeafBlock, names_triangles_near_each_other_behind_it) {
  constexpr std::uint32_t kWide = LeafBlock::kDifferences - 1;
  constexpr std::uint32_t kLast = LeafBlock::kTriangles - 1;
  for (const std::uint32_t placement : {1u, 255u, 256u, LeafBlock::kPlacements - 1}) {
    expect_names({0, 0, 0, 0}, 1, placement);
    expect_names({kLast, kLast, kLast, kLast}, 1, placement);
    expect_names({kLast - kWide, kLast, kLast - 1, kLast}, 4, placement);
    expect_names({7, 8, 7 + kWide, 7 + kWide / 2}, 4, placement);
    expect_names({7, 8, 8 + 255, 7 + 256}, 4, placement);
  }
  EXPECT_TRUE(LeafBlock::fit(5, 5 + kWide, 1));
  EXPECT_FALSE(LeafBlock::fit(5, 6 + kWide, 1));
}

TEST(LeafBlock, rounds_edges_up_by_a_sixteenth_at_most) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  LeafBlock block{};
  block.set_names({1, 2, 3, 4}, 4, 5);
  for (float edge = 0x1p-126f; edge < 0x1p127f; edge *= 1.37f) {
    block.set_edge_max(edge);
    EXPECT_GE(block.edge_max(), edge);
    EXPECT_LE(block.edge_max(), edge * 1.0625f);
  }
  // Zero, the least number, what four bits behind the point hold, the greatest number.
  const std::array<std::array<float, 2>, 7> cases{{{0, 0},
                                                   {0x1p-149f, 0x1p-130f},
                                                   {1, 1},
                                                   {1.0625f, 1.0625f},
                                                   {std::nextafter(1.0625f, 2.0f), 1.125f},
                                                   {std::numeric_limits<float>::max(), kInf},
                                                   {kInf, kInf}}};
  for (const auto& [edge, rounded] : cases) {
    block.set_edge_max(edge);
    EXPECT_EQ(block.edge_max(), rounded);
  }
  block.set_edge_max(std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(std::isnan(block.edge_max()));
  EXPECT_EQ(block.triangles(), (Named{1, 2, 3, 4}));
  EXPECT_EQ(block.placement(), 5u);
}

}  // namespace
}  // namespace sightline
