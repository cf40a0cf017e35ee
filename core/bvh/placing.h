#pragma once
/// How a placed mesh is entered: by a tree of the world, or through a map into the mesh's space.

#include "core/bvh/scene_tree.h"

namespace sightline {

/// Everything of a Placement but its tree, as if its tree had world boxes.
Placement make_placement(std::uint32_t instance, const PlacementView& view, const MeshFacts& facts);

/// Returns placement i of the plan with every member set except `tree`. Precondition: it shares no
/// tree around world triangles with others. There are three cases:
///   identity matrix          rays use the tree of the mesh without a mapping
///   !world_boxes             rays are mapped into the tree of the mesh; `space` has the map and its
///                            error bounds (docs/explanation/exactness.md, "Instances")
///   has_own_tree(placement)  the caller builds a tree around the placement's world triangles
/// The third case applies to a mesh that is placed once, a mesh with a position that is not finite,
/// and a matrix without a finite inverse. It also applies if boxes would have to grow by more than
/// 2^-24 times the largest absolute coordinate of the mesh.
///
/// moves  true: a mesh that is placed once may be mapped, because it may move soon
Placement place_alone(const ScenePlan& plan, std::uint32_t i, bool moves = false);

/// Whether the tree is to be around this placement's world triangles and nobody else's; else it is
/// that of the mesh. Precondition: it comes from place_alone.
inline bool has_own_tree(const Placement& placement) {
  return placement.world_boxes && !placement.identity;
}

}  // namespace sightline

// Tests: tests/unit/bvh/joining_test.cpp
