#pragma once
/// TreeReport: statistics of the quality of a tree, such as depth, fill and overlap of siblings,
/// and whether everything is inside of its parent's box.

#include <cstdint>

#include "core/scene/scene_view.h"

namespace sightline {

/// Statistics of one tree.
struct TreeReport {
  /// Numbers of nodes, leaves, leaf blocks and triangles.
  std::uint64_t nodes = 0, leaves = 0, blocks = 0, triangles = 0;
  std::uint32_t depth = 0;       ///< most nodes on a path from the root
  std::uint32_t shallowest = 0;  ///< fewest nodes above a leaf
  double mean_depth = 0;         ///< mean number of nodes above a leaf
  double arity = 0;              ///< mean number of children of a node
  /// Surface area heuristic: the expected number of nodes and leaf blocks that a random ray tests,
  /// if it meets the root.
  double sah_cost = 0;
  /// Overlap of siblings, as a mean over pairs of children of one node: twice the surface area of
  /// the intersection of their boxes, divided by the sum of the areas of the two. 0: disjoint, 1:
  /// equal boxes.
  double overlap = 0;
  /// True if every child's box is inside of its parent's box, and every triangle inside of its
  /// leaf's box.
  bool contained = true;
};

/// Statistics of the tree of an entry. Precondition: entry < SceneTree::entries, and its tree is
/// built. Cost: linear in the tree. Throws std::bad_alloc.
TreeReport report_tree(const SceneView& scene, std::uint32_t entry);
/// Statistics of the top tree, whose leaves hold entries instead of triangles: `triangles` counts
/// the entries. Zeros if there is no top tree.
TreeReport report_top_tree(const SceneView& scene);

}  // namespace sightline

// Tests: tests/integration/parts_test.py
