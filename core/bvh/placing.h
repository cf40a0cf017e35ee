#pragma once
/// Makes the Placements of a scene's entries, and decides how rays enter the tree of a placed mesh:
/// in world space, or by a map into the mesh's space.

#include "core/bvh/scene_tree.h"

namespace sightline {

/// Returns a placement for a tree with boxes in world space; every member but `tree` is set.
/// `instance` is the index of `view` in ScenePlan::placements, `facts` are those of its mesh.
Placement make_placement(std::uint32_t instance, const PlacementView& view, const MeshFacts& facts);

/// Returns the placement for index i of plan.placements; every member but `tree` is set.
/// Precondition: the placement does not share a tree in world space with others. The first case
/// that applies decides:
///   identity matrix          rays use the tree of the mesh without a mapping
///   has_own_tree(placement)  the caller builds a tree around the placement's world triangles
///   !world_boxes             rays are mapped into the tree of the mesh; `space` has the map and
///                            its error bounds (docs/explanation/exactness.md, "Instances")
/// The second case applies to a mesh that is placed once, a mesh with a position that is not
/// finite, and a matrix without a finite inverse. It also applies if boxes would have to grow by
/// more than 2^-24 times the largest absolute coordinate of the mesh.
///
/// moves  true: the placement may move soon; then a mesh that is placed once may be mapped too
Placement place_alone(const ScenePlan& plan, std::uint32_t i, bool moves = false);

/// True if the tree is built around the world triangles of this placement only; false if it is the
/// tree of the mesh. Precondition: the placement comes from place_alone.
inline bool has_own_tree(const Placement& placement) {
  return placement.world_boxes && !placement.identity;
}

}  // namespace sightline

// Tests: tests/unit/bvh/joining_test.cpp
