#pragma once
/// The top tree: a tree over the entries of a scene.

#include <span>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// Builds a tree over the world bounds of the entries, in units in which float32 is precise. A leaf
/// block holds one index of `bounds`. `all` must contain all bounds. Returns an empty tree if
/// cancelled.
WideTree build_top(std::span<const Box3d> bounds, const Box3d& all, TreeQuality quality,
                   const CancelFlag* cancel = nullptr);

}  // namespace sightline

// Tests: tests/unit/bvh/joining_test.cpp
