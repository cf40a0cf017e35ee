#pragma once
/// The top tree: a tree over the entries of a scene (SceneTree), through which rays find the trees
/// to enter.

#include <span>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// Builds a tree over the world bounds of the entries, which are finite and not empty, in units in
/// which float32 is precise. A leaf has one block of one lane; LeafBlock::triangle(0) is the index
/// of the entry in `bounds`. `all` must contain all bounds. Returns an empty tree if `bounds` is
/// empty or if cancelled; `cancel` may be null. Throws std::bad_alloc.
WideTree build_top(std::span<const Box3d> bounds, const Box3d& all, TreeQuality quality,
                   const CancelFlag* cancel = nullptr);

}  // namespace sightline

// Tests: tests/unit/bvh/joining_test.cpp
