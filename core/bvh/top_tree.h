#pragma once
/// The tree over what is entered one by one.

#include <span>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// A tree over the world bounds of the entries, in units in which float32 is precise. Leaf blocks
/// hold indices of `bounds`, one each. `all` contains them. Empty once it is cancelled.
WideTree build_top(std::span<const Box3d> bounds, const Box3d& all, TreeQuality quality,
                   const CancelFlag* cancel = nullptr);

}  // namespace sightline

// Tests: tests/unit/bvh/joining_test.cpp
