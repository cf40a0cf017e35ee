// Moving subtrees makes a tree better and loses nothing.

#include "core/bvh/reinsert.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>

#include "core/bvh/wide_tree.h"

namespace sightline {
namespace {

/// Thin boxes of very different lengths, so that there is much to gain.
Column<BuildBox> sticks(std::uint32_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<float>(random() >> 40) * 0x1p-24f; };
  Column<BuildBox> boxes(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto along = static_cast<int>(random() % 3);
    for (int k = 0; k < 3; ++k) {
      const float from = unit();
      const float length = k == along ? unit() * unit() : 0.001f;
      boxes[i].lower[k] = from;
      boxes[i].upper[k] = from + length;
    }
    boxes[i].id = i;
    boxes[i].padding = 0;
  }
  return boxes;
}

double inner_surface(const BinaryTree& tree) {
  double sum = 0;
  std::vector<std::uint32_t> waiting{0};
  while (!waiting.empty()) {
    const BinaryNode& node = tree[waiting.back()];
    waiting.pop_back();
    if (node.is_leaf()) continue;
    sum += static_cast<double>(node.half_area());
    waiting.push_back(node.link);
    waiting.push_back(node.link + 1);
  }
  return sum;
}

/// Counts, boxes and ranges of every node; returns how deep the tree is.
std::uint32_t check(const BinaryTree& tree, const Column<BuildBox>& boxes) {
  std::uint32_t deepest = 0;
  // Returns the first box below and checks that the boxes below are one range.
  const std::function<std::uint32_t(std::uint32_t, std::uint32_t)> walk =
      [&](std::uint32_t i, std::uint32_t depth) -> std::uint32_t {
    const BinaryNode& node = tree[i];
    deepest = std::max(deepest, depth);
    std::uint32_t first = node.link;
    if (!node.is_leaf()) {
      first = walk(node.link, depth + 1);
      const std::uint32_t middle = walk(node.link + 1, depth + 1);
      EXPECT_EQ(middle, first + tree[node.link].box_count());
      EXPECT_EQ(node.box_count(), tree[node.link].box_count() + tree[node.link + 1].box_count());
    }
    for (std::uint32_t b = first; b < first + node.box_count(); ++b) {
      const BuildBox& box = boxes[tree.ids[b]];
      for (int k = 0; k < 3; ++k) {
        EXPECT_LE(node.lower[k], box.lower[k]);
        EXPECT_GE(node.upper[k], box.upper[k]);
      }
    }
    return first;
  };
  EXPECT_EQ(walk(0, 1), 0u);
  std::vector<std::uint32_t> ids(tree.ids.begin(), tree.ids.end());
  std::sort(ids.begin(), ids.end());
  std::vector<std::uint32_t> all(boxes.size());
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(ids, all);
  return deepest;
}

TEST(Reinsert, makes_the_tree_smaller_and_keeps_every_box_in_its_range) {
  for (const std::uint32_t count : {1u, 2u, 5u, 9u, 100u, 5000u}) {
    for (const std::uint32_t leaf_max : {1u, 4u}) {
      const Column<BuildBox> boxes = sticks(count, 7);
      BinaryOptions options;
      options.leaf_max = leaf_max;
      BinaryTree tree = build_binary_tree(boxes, options);
      const double before = inner_surface(tree);
      check(tree, boxes);
      reinsert(tree, {8, 1.0f, 0});
      const double after = inner_surface(tree);
      EXPECT_LE(check(tree, boxes), kMaxTreeDepth);
      EXPECT_LE(after, before * 1.0001) << count;
      if (count == 5000) {
        EXPECT_LT(after, before * 0.97);
      }
    }
  }
}

TEST(Reinsert, survives_boxes_that_are_all_the_same) {
  Column<BuildBox> boxes = sticks(1, 1);
  boxes.resize(600, boxes[0]);
  for (std::uint32_t i = 0; i < boxes.size(); ++i) boxes[i].id = i;
  BinaryOptions options;
  options.leaf_max = 1;
  BinaryTree tree = build_binary_tree(boxes, options);
  reinsert(tree, {3, 1.0f, 0});
  EXPECT_LE(check(tree, boxes), kMaxTreeDepth);
}

}  // namespace
}  // namespace sightline
