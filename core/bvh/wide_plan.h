#pragma once
/// Which nodes of a binary tree become the children of a wide node, at the least cost.

#include <array>

#include "core/bvh/collapse.h"

namespace sightline {

/// Granules up to the next place for a node.
inline std::uint32_t whole_lines(std::uint32_t granules) {
  constexpr std::uint32_t kLine = kNodeAlign / Arena::kGranule;
  return (granules + kLine - 1) / kLine * kLine;
}

/// Children of one wide node as indices of binary nodes.
struct WideChildren {
  std::array<std::uint32_t, kArity> index{};
  std::size_t count = 0;
};

/// The dynamic programme of [Ylitie2017], 3.1: for every binary node the cheapest way to represent
/// what is below it by at most 1, 2, ... 7 wide nodes or leaves.
class WidePlan {
 public:
  /// Parallel for large trees. Cost: 8 bytes per binary node. Of no use once it is cancelled.
  /// Precondition: not empty.
  WidePlan(const BinaryTree& binary, const CollapseOptions& options);

  bool is_leaf(std::uint32_t node) const { return (choice_[node] & kLeaf) != 0; }
  /// Granules of a binary node that was chosen to be a wide node or a leaf, all below included.
  std::uint32_t granules(std::uint32_t node) const { return granules_[node]; }
  /// Precondition: !is_leaf(root).
  WideChildren children(std::uint32_t root) const;
  /// Expected cost of a ray that meets the root's box, memory not counted.
  float cost() const { return cost_; }

  /// The boxes below a binary node are [first, first + count).
  std::uint32_t first_box(std::uint32_t node) const {
    while (!binary_[node].is_leaf()) node = binary_[node].link;
    return binary_[node].link;
  }
  /// Leaf blocks for them. Precondition: so few boxes that a leaf may hold them.
  std::uint32_t blocks(std::uint32_t node) const {
    const std::uint32_t boxes = binary_[node].box_count();
    if (options_.count_blocks) return options_.count_blocks(first_box(node), boxes);
    return (boxes + options_.block - 1) / options_.block;
  }

 private:
  static constexpr std::uint32_t kLeaf = 0x80000000u;
  /// The least cost, and the granules that go with it, for at most i + 1 roots.
  struct Forest {
    std::array<float, kArity> cost{};
    std::array<std::uint32_t, kArity> granules{};
  };

  Forest solve(std::uint32_t node);
  void gather(std::uint32_t node, std::uint32_t roots, WideChildren& children) const;
  /// How many of at most `roots` roots come from the left child; 0: one root fewer is as good.
  std::uint32_t from_left(std::uint32_t node, std::uint32_t roots) const {
    return choice_[node] >> (3 * (roots - 2)) & 7u;
  }

  const BinaryTree& binary_;
  const CollapseOptions& options_;
  float memory_cost_;             ///< of a granule, in the units of surface times steps
  Column<std::uint32_t> choice_;  ///< from_left for 2 to 8 roots, three bits each, and kLeaf
  Column<std::uint32_t> granules_;
  float cost_ = 0;
};

}  // namespace sightline

// Tests: tests/unit/bvh/triangle_tree_test.cpp
