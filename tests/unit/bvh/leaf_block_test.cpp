// What is packed into a leaf block comes out again.

#include "core/bvh/leaf_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/bvh/block_vertices.h"

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

TEST(LeafBlock, states_the_capacity_and_the_size) {
  LeafBlock block{};
  block.set_names({7, 8, 9, 10}, 4, 3);
  block.set_edge_max(1.5f);
  EXPECT_EQ(block.capacity(), 0u);
  for (const auto& [capacity, granules] : {std::pair{12u, 5u}, {6u, 3u}, {8u, 4u}, {0u, 1u}}) {
    block.set_capacity(capacity);
    EXPECT_EQ(block.capacity(), capacity);
    EXPECT_EQ(block.granules(), granules);
    EXPECT_EQ(LeafBlock::granules_for(capacity), granules);
    EXPECT_EQ(block.has_numbers(), capacity == 6 || capacity == 8);
    EXPECT_EQ(block.triangles(), (Named{7, 8, 9, 10}));
    EXPECT_EQ(block.lane_count(), 4u);
    EXPECT_EQ(block.placement(), 3u);
    EXPECT_EQ(block.edge_max(), 1.5f);
    block.set_names({7, 8, 9, 10}, 4, 3);
    EXPECT_EQ(block.capacity(), capacity);
  }
}

/// Checks the capacity that the triangles need, and that places are equal where their indices are.
void expect_vertices(const std::vector<std::uint32_t>& indices, const Named& triangles,
                     std::uint32_t capacity) {
  const BlockVertices vertices{IndexView(indices), triangles};
  EXPECT_EQ(vertices.capacity(), capacity);
  for (std::size_t place = 0; place < LeafBlock::kMostVertices; ++place) {
    EXPECT_EQ(vertices.index(place),
              indices[std::size_t{3} * triangles[place % kLanes] + place / kLanes]);
    std::size_t first = 0;
    while (vertices.index(first) != vertices.index(place)) ++first;
    EXPECT_EQ(vertices.first(place), first);
  }
}

TEST(BlockVertices, are_shared_where_they_fit) {
  const std::vector<std::uint32_t> strip{0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5};
  expect_vertices(strip, {0, 1, 2, 3}, 6);
  expect_vertices(strip, {3, 0, 3, 3}, 6);
  expect_vertices(strip, {1, 1, 1, 1}, 6);
  const std::vector<std::uint32_t> fan{9, 0, 1, 9, 1, 2, 9, 2, 3, 9, 3, 9};
  expect_vertices(fan, {0, 1, 2, 3}, 6);
  const std::vector<std::uint32_t> apart{0, 1, 2, 2, 1, 3, 14, 11, 12, 12, 11, 13};
  expect_vertices(apart, {0, 1, 2, 3}, 8);
  expect_vertices(apart, {0, 2, 2, 0}, 6);
  const std::vector<std::uint32_t> soup{0, 1, 2, 3, 4, 5, 6, 7, 8, 8, 9, 0xfffffffeu};
  expect_vertices(soup, {0, 1, 2, 3}, 12);
  expect_vertices(soup, {0, 1, 0, 0}, 6);
}

TEST(BlockVertices, are_not_searched_without_a_list_of_indices) {
  const IndexView sequence = IndexView::sequence(12);
  EXPECT_EQ(BlockVertices(sequence, {0, 1, 2, 3}).capacity(), 12u);
  EXPECT_EQ(BlockVertices(sequence, {3, 1, 3, 3}).capacity(), 6u);
  EXPECT_EQ(BlockVertices(sequence, {3, 3, 3, 3}).index(0), 9u);
}

}  // namespace
}  // namespace sightline
