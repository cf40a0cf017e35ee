#pragma once
/// How a placed mesh is entered: by a tree of the world, or through a map into the mesh's space.

#include "core/bvh/scene_tree.h"

namespace sightline {

/// Everything of a Placement but its tree, as if its tree had world boxes.
Placement make_placement(std::uint32_t instance, const PlacementView& view, const MeshFacts& facts);

/// Whether placement i of the plan shares its mesh's tree and rays are mapped into its space; then
/// `space` says how, with every error bounded (docs/exactness.md, "Instances"). A mesh that is
/// placed once, or whose boxes would have to grow by more than a 2^-24th of it, is not.
bool is_mapped(const ScenePlan& plan, std::uint32_t i, TreeSpace& space);

}  // namespace sightline
