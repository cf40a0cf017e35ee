#pragma once
/// The second of three steps of building: moves subtrees of a binary tree to where they enlarge
/// fewer boxes.

#include <cstdint>

#include "core/bvh/binary_tree.h"

namespace sightline {

/// Options of reinsert.
struct ReinsertOptions {
  int passes = 3;  ///< the most passes; a pass that gains less than least_gain is the last
  /// The share of nodes that each pass tries to move, those with the largest surface area. The
  /// first pass tries only a quarter of them, to find out if moving gains anything.
  float share = 0.2f;
  /// Another pass follows if a pass reduces the surface area of all inner nodes by this share.
  float least_gain = 0.005f;
  /// Cancels the call when set; may be null.
  const CancelFlag* cancel = nullptr;
};

/// Moves subtrees to reduce the surface area of the tree. In each pass, branch and bound finds the
/// best new place of every chosen subtree, in parallel. Then the moves are made, largest gain
/// first, if they do not touch nodes of an earlier move [Meister2018]. Unlike in that paper, one
/// thread makes the moves in a fixed order, so that the tree does not depend on the number of
/// threads. Leaves are not divided. Finally ids are sorted so that every node again covers a range.
/// No binary node gets deeper than kMaxTreeDepth. A cancelled call leaves the tree unchanged.
/// Throws std::bad_alloc.
void reinsert(BinaryTree& tree, const ReinsertOptions& options);

}  // namespace sightline
