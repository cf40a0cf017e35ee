#pragma once
/// BinaryTree: a binary tree over boxes, built top-down by the surface-area heuristic. It is the
/// first of three steps: reinsert.h improves it, and collapse.h converts it into the eight-wide
/// tree that rays traverse.

#include <cstdint>

#include "core/base/arena.h"
#include "core/base/column.h"
#include "core/base/deadline.h"
#include "core/bvh/build_box.h"
#include "core/bvh/histogram.h"

namespace sightline {

/// A node, inner or leaf. Its bounds are lower to upper, in tree units.
struct alignas(32) BinaryNode {
  /// The bit of `mark` that an inner node has.
  static constexpr std::uint32_t kInner = 0x80000000u;

  float lower[3];
  /// leaf: index in BinaryTree::ids of its first id; inner: index of its left child, whose next
  /// node is the right child
  std::uint32_t link;
  float upper[3];
  /// number of ids below the node; an inner node has the bit kInner set as well
  std::uint32_t mark;

  bool is_leaf() const { return (mark & kInner) == 0; }
  std::uint32_t id_count() const { return mark & ~kInner; }
  /// Half the surface area of the bounds.
  float half_area() const {
    return (Float4::load(upper) - Float4::load(lower)).without_last().product_sum();
  }
};

/// A binary tree. Node 0 is the root; operator[] reads a node.
struct BinaryTree {
  Arena nodes;  ///< BinaryNode[]; the root has index 0, the order of the others has no meaning
  std::uint32_t node_end = 0;  ///< one above the largest index in use
  /// numbers of the triangles or entries in the boxes, sorted so that a node has a range of them
  Column<std::uint32_t> ids;

  bool empty() const { return ids.empty(); }
  const BinaryNode& operator[](std::uint32_t i) const {
    return reinterpret_cast<const BinaryNode*>(nodes.at(0))[i];
  }
  BinaryNode& operator[](std::uint32_t i) { return reinterpret_cast<BinaryNode*>(nodes.at(0))[i]; }
};

/// Options of build_binary_tree.
struct BinaryOptions {
  /// How many triangles the leaves of the final tree test at once: 4 by default.
  BlockSize block_size{2};
  /// A leaf has at most this many triangles, or one box.
  std::uint32_t leaf_max = 4;
  /// From this depth on, ranges are halved by count instead of by cost, so that no node is deeper
  /// than kMaxTreeDepth.
  std::uint32_t max_depth = 96;
  const CancelFlag* cancel = nullptr;  ///< may be null
};

/// Builds a tree over `boxes`, which are finite and not empty boxes, and consumes them. Parallel
/// for large inputs; the tree does not depend on the number of threads. Returns an empty tree if
/// there are no boxes or if cancelled. Throws std::bad_alloc. Precondition: every BuildBox::count
/// is at least 1, and their sum is less than 2^31.
BinaryTree build_binary_tree(Column<BuildBox> boxes, const BinaryOptions& options);

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
