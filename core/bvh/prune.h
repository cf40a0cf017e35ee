#pragma once
/// Removes placements from a tree that several placements share.

#include <functional>

#include "core/bvh/wide_tree.h"

namespace sightline {

/// Returns a copy of the tree without the leaf blocks for whose LeafBlock::placement() `gone`
/// returns true. A leaf without blocks becomes kEmpty. Nodes and other boxes do not change, so
/// nodes may be left that contain nothing, and boxes still contain the rest. Cost: a copy of the
/// arena and a traversal. Throws std::bad_alloc.
WideTree without_placements(const WideTree& tree,
                            const std::function<bool(std::uint32_t placement)>& gone);

}  // namespace sightline

// Tests: tests/unit/run/moved_test.cpp
