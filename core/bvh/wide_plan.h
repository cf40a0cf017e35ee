#pragma once
/// WidePlan: chooses which nodes of a binary tree become the children of a wide node, at the least
/// cost. collapse() writes the tree that it chose.

#include <array>

#include "core/bvh/collapse.h"

namespace sightline {

/// Subtrees with fewer boxes are planned and written by one thread.
inline constexpr std::uint32_t kParallelBoxes = 1u << 14;

/// Rounds a number of granules (32 bytes) up to a multiple of a node's alignment.
inline std::uint32_t whole_lines(std::uint32_t granules) {
  constexpr std::uint32_t kLine = kNodeAlign / Arena::kGranule;
  return (granules + kLine - 1) / kLine * kLine;
}

/// The children of a wide node, as indices of binary nodes: index[0] .. index[count - 1].
struct WideChildren {
  std::array<std::uint32_t, kArity> index{};
  std::size_t count = 0;
};

/// The dynamic programme of [Ylitie2017], section 3.1. For every binary node it finds the cheapest
/// way to represent its subtree by at most 1, 2, ... 8 wide nodes or leaves. A binary node is
/// chosen if it becomes a wide node or a leaf: start with node 0, and go on with its children().
class WidePlan {
 public:
  /// Solves the programme. Parallel for large trees. Cost: 8 bytes per binary node. If
  /// options.cancel is set meanwhile, the plan must not be used. Precondition: the tree is not
  /// empty. The arguments must outlive the plan. Throws std::bad_alloc.
  WidePlan(const BinaryTree& binary, const CollapseOptions& options, const LeafContent& content);

  /// True if the binary node, if chosen, becomes a leaf and not a wide node.
  bool is_leaf(std::uint32_t node) const { return (choice_[node] & kLeaf) != 0; }
  /// True if the blocks of a binary node that is, or is part of, a leaf are those of its left child,
  /// followed by those of its right child. False: its boxes share blocks.
  bool has_blocks_of_children(std::uint32_t node) const {
    return (choice_[node] & kBlocksOfChildren) != 0;
  }
  /// The granules of memory that a chosen wide node or leaf needs, with everything below it.
  std::uint32_t granules(std::uint32_t node) const { return granules_[node]; }
  /// The children of the wide node that a chosen binary node becomes. Precondition: !is_leaf(root).
  WideChildren children(std::uint32_t root) const;
  /// Expected cost of a ray that meets the root's box, CollapseOptions::memory_cost included. 0 if
  /// the root's box has no surface.
  float cost() const { return cost_; }

  /// The first of the ids below a binary node: they are [first, first + id_count()).
  std::uint32_t first_id(std::uint32_t node) const {
    while (!binary_[node].is_leaf()) node = binary_[node].link;
    return binary_[node].link;
  }

 private:
  static constexpr std::uint32_t kLeaf = 0x80000000u, kBlocksOfChildren = 0x40000000u;
  /// The least cost, and the granules for it, if a subtree is represented by at most i + 1 roots.
  struct Forest {
    std::array<float, kArity> cost{};
    std::array<std::uint32_t, kArity> granules{};
    LeafSize leaf;  ///< as a leaf; unset if the subtree has too many boxes for one
  };

  Forest solve(std::uint32_t node);
  LeafSize leaf_size(std::uint32_t node) const {
    return content_.size(first_id(node), binary_[node].id_count());
  }
  void gather(std::uint32_t node, std::uint32_t roots, WideChildren& children) const;
  /// How many of at most `roots` roots are below the left child; 0: one root fewer costs no more.
  std::uint32_t from_left(std::uint32_t node, std::uint32_t roots) const {
    return choice_[node] >> (3 * (roots - 2)) & 7u;
  }

  const BinaryTree& binary_;
  const CollapseOptions& options_;
  const LeafContent& content_;
  float memory_cost_;  ///< cost of a granule, in units of surface area times steps
  /// for each node: from_left for 2 to 8 roots, three bits each, and the bits above
  Column<std::uint32_t> choice_;
  Column<std::uint32_t> granules_;
  float cost_ = 0;
};

}  // namespace sightline

// Tests: tests/unit/bvh/triangle_tree_test.cpp
