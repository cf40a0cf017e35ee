#pragma once
/// Improves a binary tree by moving subtrees to where they enlarge fewer boxes.

#include <cstdint>

#include "core/bvh/binary_tree.h"

namespace sightline {

struct ReinsertOptions {
  int passes = 3;  ///< at most; a pass that saves too little is the last
  /// The share of nodes, those with the largest surface, that each pass tries. The first pass tries
  /// a quarter of them, to find out whether there is anything to save.
  float share = 0.2f;
  /// A pass is followed by another one if it saves this share of the surface of all inner nodes.
  float least_gain = 0.005f;
  const CancelFlag* cancel = nullptr;
};

/// In each pass, branch and bound finds the best new place of every chosen subtree, in parallel.
/// Then the moves are made, most profitable first, as far as they do not touch each other
/// [Meister2018]. Unlike there, one thread makes the moves in a fixed order, so that the tree does
/// not depend on the number of threads. Leaves stay whole. Ids are sorted again so that the boxes
/// below every node are one range. No binary node gets deeper than kMaxTreeDepth. A cancelled call
/// leaves the tree as it was. Throws std::bad_alloc.
void reinsert(BinaryTree& tree, const ReinsertOptions& options);

}  // namespace sightline
