#pragma once
/// How a placed mesh is entered: by a tree of the world, or through a map into the mesh's space.

#include "core/bvh/scene_tree.h"

namespace sightline {

/// Everything of a Placement but its tree, as if its tree had world boxes.
Placement make_placement(std::uint32_t instance, const PlacementView& view, const MeshFacts& facts);

/// Everything of placement i of the plan but its tree, if it does not share a tree of the world.
/// Rays are mapped into the tree of its mesh, with every error bounded
/// (docs/explanation/exactness.md, "Instances"), or has_own_tree. Rays are not mapped into a mesh
/// that is placed once, or whose boxes would have to grow by more than 2^-24 of their size.
///
/// moves  rays are mapped into a mesh that is placed once too, as it may move soon
Placement place_alone(const ScenePlan& plan, std::uint32_t i, bool moves = false);

/// Whether the tree is to be around this placement's world triangles and nobody else's; else it is
/// that of the mesh. Precondition: it comes from place_alone.
inline bool has_own_tree(const Placement& placement) {
  return placement.world_boxes && !placement.identity;
}

}  // namespace sightline

// Tests: tests/unit/bvh/joining_test.cpp
