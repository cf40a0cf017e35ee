#pragma once
/// A binary tree over boxes, built from the top by the surface-area heuristic: the first step of
/// building. What follows improves it (reinsert) and makes it eight-wide (collapse).

#include <cstdint>

#include "core/base/arena.h"
#include "core/base/column.h"
#include "core/base/deadline.h"
#include "core/bvh/build_box.h"
#include "core/bvh/histogram.h"

namespace sightline {

struct alignas(32) BinaryNode {
  static constexpr std::uint32_t kInner = 0x80000000u;

  float lower[3];
  std::uint32_t link;  ///< leaf: its first box; inner: its left child (the right one is the next)
  float upper[3];
  std::uint32_t mark;  ///< boxes below; kInner is set for an inner node

  bool is_leaf() const { return (mark & kInner) == 0; }
  std::uint32_t box_count() const { return mark & ~kInner; }
  float half_area() const {
    return (Float4::load(upper) - Float4::load(lower)).without_last().product_sum();
  }
};

struct BinaryTree {
  Arena nodes;                 ///< the root is the first; which index another one has means nothing
  std::uint32_t node_end = 0;  ///< above every index in use
  Column<std::uint32_t> ids;   ///< of the boxes, so that every leaf is a range of them

  bool empty() const { return ids.empty(); }
  const BinaryNode& operator[](std::uint32_t i) const {
    return reinterpret_cast<const BinaryNode*>(nodes.at(0))[i];
  }
  BinaryNode& operator[](std::uint32_t i) { return reinterpret_cast<BinaryNode*>(nodes.at(0))[i]; }
};

struct BinaryOptions {
  BlockSize block_size{2};
  std::uint32_t leaf_max = 4;  ///< ranges are cut until they are not larger
  /// Below it ranges are halved in the middle, so that depth stays bounded (kMaxTreeDepth).
  std::uint32_t max_depth = 96;
  const CancelFlag* cancel = nullptr;
};

/// Consumes `boxes`, which are finite and not empty. Parallel for large inputs; the tree does not
/// depend on the number of threads. Empty once it is cancelled.
BinaryTree build_binary_tree(Column<BuildBox> boxes, const BinaryOptions& options);

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
