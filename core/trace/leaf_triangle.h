#pragma once
/// The world triangle of a lane of a leaf block.

#include "core/bvh/scene_tree.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// Maps the corners of a lane to world space by the arithmetic of Scene::world_triangle, so the
/// result is that triangle, bit by bit. `placement` is that of the block. Precondition: lane <
/// block.lane_count().
inline Triangle world_triangle(const Placement& placement, const LeafBlock& block,
                               std::size_t lane) {
  const auto corner = [&](std::size_t c) {
    return placement.world_from_mesh.apply(block.corner(c, lane));
  };
  return {corner(0), corner(1), corner(2)};
}

}  // namespace sightline

// Tests: tests/unit/trace/box_overlap_test.cpp
