#pragma once
/// Removes placements from a tree that several placements share.

#include <functional>

#include "core/bvh/wide_tree.h"

namespace sightline {

/// Returns a copy of the tree without the leaf blocks for whose LeafBlock::placement() `gone`
/// returns true. Boxes do not change, so they still contain the rest. If nothing is left, the root
/// is kEmpty. Cost: a copy of the arena and a traversal. Throws std::bad_alloc.
WideTree without_placements(const WideTree& tree,
                            const std::function<bool(std::uint32_t placement)>& gone);

}  // namespace sightline

// Tests: tests/unit/run/moved_test.cpp
