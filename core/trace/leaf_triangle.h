#pragma once
/// A lane of a leaf block as the world sees it.

#include "core/bvh/scene_tree.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// By the same arithmetic as Scene::world_triangle. `placement` is the block's.
inline Triangle world_triangle(const Placement& placement, const LeafBlock& block,
                               std::size_t lane) {
  const auto corner = [&](std::size_t c) {
    const Vec3f p{block.corner[c][0][lane], block.corner[c][1][lane], block.corner[c][2][lane]};
    return placement.world_from_mesh.apply(p);
  };
  return {corner(0), corner(1), corner(2)};
}

}  // namespace sightline

// Tests: tests/unit/trace/box_overlap_test.cpp
