#pragma once
/// The last of three steps of building: converts a binary tree into eight-wide nodes in one arena
/// [Dammertz2008].

#include <functional>

#include "core/bvh/binary_tree.h"
#include "core/bvh/wide_tree.h"

namespace sightline {

/// The blocks of a leaf, and their memory in granules (Arena::kGranule).
struct LeafSize {
  std::uint32_t blocks = 0;
  std::uint32_t granules = 0;
};

/// What the leaves of a tree contain. Both functions get ids that share blocks as a range of
/// BinaryTree::ids, [first, first + count), and are called from several threads at once.
struct LeafContent {
  /// Returns the size of the blocks.
  std::function<LeafSize(std::uint32_t first, std::uint32_t count)> size;
  /// Writes the blocks, one behind the other from `blocks` on. Returns the end of the last one. The
  /// memory is that of the size, and zero.
  std::function<LeafBlock*(std::uint32_t first, std::uint32_t count, LeafBlock* blocks)> write;
};

/// The costs of the steps of a traversal, of which only ratios matter, and the sizes of leaves.
struct CollapseOptions {
  /// Cost of testing a node's eight child boxes.
  float node_cost = 1.0f;
  /// Cost of testing a block of triangles.
  float block_cost = 1.2f;
  /// Cost of a granule (32 bytes) of memory, divided by the number of ids. It makes a larger tree
  /// worth building only if it saves time.
  float memory_cost = 1.5f;
  std::uint32_t block = kLanes;  ///< ids that fit in a leaf block
  std::uint32_t leaf_max = 8;    ///< most ids in a leaf, unless a leaf of the binary tree has more
  /// May be null.
  const CancelFlag* cancel = nullptr;
};

/// Chooses which binary nodes become wide nodes and which subtrees become leaves, so that the
/// expected cost of a ray is the least possible for this binary tree [Ylitie2017]. Writes nodes
/// depth first, each followed by its leaves. Sets every member of WideTree except scale_exponent
/// and bounds. Parallel; the bytes do not depend on the number of threads. Returns an empty tree if
/// `binary` is empty or if cancelled. Throws std::bad_alloc.
WideTree collapse(const BinaryTree& binary, const CollapseOptions& options,
                  const LeafContent& content);

}  // namespace sightline

// Tests: tests/unit/bvh/triangle_tree_test.cpp
