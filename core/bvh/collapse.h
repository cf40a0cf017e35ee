#pragma once
/// The second step of building: a binary tree becomes eight-wide nodes in one arena.

#include <functional>

#include "core/bvh/binary_tree.h"
#include "core/bvh/wide_tree.h"

namespace sightline {

/// Fills `blocks` consecutive leaf blocks with the boxes [first, first + count) of the build.
using LeafWriter = std::function<void(std::uint32_t first, std::uint32_t count, LeafBlock* blocks)>;

/// Opens the child with the largest surface until a node has eight [Wald2008], writes nodes depth
/// first, each followed by its own leaves. Leaves hold ceil(count / kLanes) blocks.
/// Sets everything of WideTree but scale_exponent and bounds. Throws std::bad_alloc.
WideTree collapse(const BinaryTree& binary, const LeafWriter& write_leaf);

}  // namespace sightline
