#pragma once
/// A tree of several placements without some of them.

#include <functional>

#include "core/bvh/wide_tree.h"

namespace sightline {

/// A copy in which no leaf block of a placement is left for which `gone(LeafBlock::placement)` is
/// true. Boxes stay as they were, so what was contained still is; kEmpty as root if nothing is
/// left in a tree of one leaf. Cost: a copy of the arena and a walk; throws std::bad_alloc.
WideTree without_placements(const WideTree& tree,
                            const std::function<bool(std::uint32_t placement)>& gone);

}  // namespace sightline

// Tests: tests/unit/run/moved_test.cpp
