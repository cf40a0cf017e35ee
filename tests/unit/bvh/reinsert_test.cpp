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
    boxes[i].count = 1;
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
      EXPECT_EQ(middle, first + tree[node.link].id_count());
      EXPECT_EQ(node.id_count(), tree[node.link].id_count() + tree[node.link + 1].id_count());
    }
    for (std::uint32_t b = first; b < first + node.id_count(); ++b) {
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

TEST(BinaryTree, has_each_triangle_of_boxes_with_several_once) {
  Column<BuildBox> boxes = sticks(3000, 3);
  Column<std::uint32_t> box_of;  // by triangle
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    boxes[i].id = static_cast<std::uint32_t>(box_of.size());
    boxes[i].count = 1 + i % 2;
    box_of.resize(box_of.size() + boxes[i].count, i);
  }
  const BinaryTree tree = build_binary_tree(boxes, {});
  std::vector<std::uint32_t> ids;
  const std::function<std::uint32_t(std::uint32_t)> walk = [&](std::uint32_t i) {
    const BinaryNode& node = tree[i];
    if (!node.is_leaf()) {
      const std::uint32_t count = walk(node.link) + walk(node.link + 1);
      EXPECT_EQ(node.id_count(), count);
      return count;
    }
    EXPECT_LE(node.id_count(), 4u);
    for (std::uint32_t k = 0; k < node.id_count(); ++k) {
      const std::uint32_t id = tree.ids[node.link + k];
      ids.push_back(id);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(node.lower[axis], boxes[box_of[id]].lower[axis]);
        EXPECT_GE(node.upper[axis], boxes[box_of[id]].upper[axis]);
      }
    }
    return node.id_count();
  };
  EXPECT_EQ(walk(0), box_of.size());
  std::sort(ids.begin(), ids.end());
  std::vector<std::uint32_t> all(box_of.size());
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(ids, all);
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
