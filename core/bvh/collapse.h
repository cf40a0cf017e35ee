#pragma once
/// The last step of building: a binary tree becomes eight-wide nodes in one arena [Dammertz2008].

#include <functional>

#include "core/bvh/binary_tree.h"
#include "core/bvh/wide_tree.h"

namespace sightline {

/// Fills consecutive leaf blocks with the boxes [first, first + count) of BinaryTree::ids. Called
/// from several threads at once.
using LeafWriter = std::function<void(std::uint32_t first, std::uint32_t count, LeafBlock* blocks)>;

/// How many leaf blocks the boxes [first, first + count) of BinaryTree::ids need. Called from
/// several threads at once.
using BlockCounter = std::function<std::uint32_t(std::uint32_t first, std::uint32_t count)>;

/// The cost of each step of a traversal; only ratios matter.
struct CollapseOptions {
  float node_cost = 1.0f;
  float block_cost = 1.2f;
  /// For each granule of memory, spread over the boxes: what costs memory must be worth it.
  float memory_cost = 1.5f;
  std::uint32_t block = kLanes;  ///< boxes in a block
  std::uint32_t leaf_max = 8;    ///< boxes in a leaf at most, if the binary leaves are not larger
  /// Where boxes cannot share a block with any other: boxes that need more than kMaxLeafBlocks are
  /// no leaf. Empty: as few blocks as hold the boxes.
  BlockCounter count_blocks;
  const CancelFlag* cancel = nullptr;
};

/// Chooses which binary nodes become wide ones and which subtrees become leaves so that the
/// expected cost of a ray is the least that this binary tree allows [Ylitie2017]. Writes nodes
/// depth first, each followed by its own leaves. Sets everything of WideTree but scale_exponent and
/// bounds. Parallel; the bytes do not depend on the number of threads. Empty once it is cancelled.
/// Throws std::bad_alloc.
WideTree collapse(const BinaryTree& binary, const CollapseOptions& options,
                  const LeafWriter& write_leaf);

}  // namespace sightline

// Tests: tests/unit/bvh/triangle_tree_test.cpp
