#pragma once
/// Binned SAH over boxes [Wald2007], the first of two steps: a binary tree that collapse turns into
/// eight-wide nodes.

#include <cstdint>

#include "core/base/arena.h"
#include "core/base/column.h"

namespace sightline {

/// A box and what it bounds. 32 bytes, so that a partition moves whole vectors.
struct alignas(32) BuildBox {
  float lower[3];
  std::uint32_t id;
  float upper[3];
  std::uint32_t padding;
};

struct alignas(32) BinaryNode {
  float lower[3];
  std::uint32_t
      link;  ///< leaf: its first box; inner: its right child (the left one is the next node)
  float upper[3];
  std::uint32_t count;  ///< boxes of a leaf; 0 for an inner node
};

/// A node over n boxes keeps 2n - 1 slots for itself and its descendants, left before right, so
/// that subtrees can be built side by side and still land where they would have in sequence.
struct BinaryTree {
  Arena slots;
  std::uint32_t box_count = 0;

  bool empty() const { return box_count == 0; }
  const BinaryNode& operator[](std::uint32_t i) const {
    return reinterpret_cast<const BinaryNode*>(slots.at(0))[i];
  }
};

struct BinaryOptions {
  std::uint32_t block = 4;     ///< boxes that are tested together: a leaf costs whole blocks
  std::uint32_t leaf_max = 8;  ///< boxes in a leaf at most
  float node_cost = 1.0f;      ///< of a binary step against one block
  std::uint32_t max_depth =
      96;  ///< beyond it ranges are halved in the middle, so that depth stays bounded
};

/// Sorts `boxes` so that every leaf is a range of it. Parallel for large inputs; the result does
/// not depend on the number of threads. Boxes are finite and not empty.
BinaryTree build_binary_tree(Column<BuildBox>& boxes, const BinaryOptions& options);

}  // namespace sightline
