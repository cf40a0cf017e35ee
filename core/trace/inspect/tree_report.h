#pragma once
/// A report on the trees of a scene: how deep and how full they are, how much siblings overlap, and
/// whether everything lies inside the box that its parent stores for it.

#include <cstdint>

#include "core/scene/scene_view.h"

namespace sightline {

/// Statistics of one tree.
struct TreeReport {
  std::uint64_t nodes = 0, leaves = 0, blocks = 0, triangles = 0;
  std::uint32_t depth = 0;       ///< nodes on the longest way down
  std::uint32_t shallowest = 0;  ///< and on the shortest way to a leaf
  double mean_depth = 0;         ///< of the leaves
  double arity = 0;              ///< children of a node, on average
  /// Surface area heuristic: of the rays that meet the root, how many nodes and leaf blocks each
  /// meets on average, if they come from everywhere.
  double sah_cost = 0;
  /// For the children of a node, on average: areas of the boxes that two of them share, over the
  /// areas of the two.
  double overlap = 0;
  /// Every child's box lies inside its parent's, and every triangle inside its leaf's.
  bool contained = true;
};

/// Precondition: entry < SceneTree::entries; its tree is there. Cost: linear in the tree. Throws
/// std::bad_alloc.
TreeReport report_tree(const SceneView& scene, std::uint32_t entry);
/// Statistics of the tree over the entries, whose leaves hold these.
TreeReport report_top_tree(const SceneView& scene);

}  // namespace sightline

// Tests: tests/integration/parts_test.py
