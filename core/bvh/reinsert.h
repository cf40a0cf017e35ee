#pragma once
/// Improves a binary tree by moving subtrees to where they enlarge fewer boxes.

#include <cstdint>

#include "core/bvh/binary_tree.h"

namespace sightline {

struct ReinsertOptions {
  int passes = 3;  ///< at most; they end when one saves too little
  /// Of the nodes, those with the largest surface are tried in each pass; in the first, which finds
  /// out whether there is anything to save, only a quarter of them.
  float share = 0.2f;
  /// Of the surface of all inner nodes: what a pass must save to be followed by another one.
  float least_gain = 0.005f;
  const CancelFlag* cancel = nullptr;
};

/// In each pass the best new place of every chosen subtree is sought in the same tree, in parallel,
/// by branch and bound; then the moves are made, the most profitable first, as far as they do not
/// touch each other [Meister2018]. We differ: the moves are made by one thread in a fixed order, so
/// that the tree does not depend on the number of threads.
/// Leaves stay whole; ids are sorted anew so that the boxes below every node are one range again.
/// No binary node comes to lie deeper than kMaxTreeDepth. Once it is cancelled the tree is what it
/// was. Throws std::bad_alloc.
void reinsert(BinaryTree& tree, const ReinsertOptions& options);

}  // namespace sightline
