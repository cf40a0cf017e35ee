#pragma once
/// Meshes with positions that clients set, and what other changes of a scene's meshes need.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/scene/edited_nodes.h"
#include "core/scene/poser.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// By mesh: true if its content must stay although no instance may have it, because trees of other
/// meshes with equal content read it. Empty: none.
using HeldMeshes = std::vector<bool>;

/// Gives each node that a change sets the positions of a mesh with them; all its instances have it.
/// Nodes with equal positions of one mesh of the file share a mesh, also with nodes that nobody
/// changed. Removed nodes are left out. Adds the meshes and instances to `posed`, and removes meshes
/// without an instance. Errors, with the pointer /positions of the change:
///   NODE_MESHLESS         the node has no triangles
///   NODE_POSED            a skin or morph targets pose its mesh
///   NODE_POSITIONS_WRONG  another number than that of the vertices of the mesh
/// Cost: that of a degenerate_triangles.h count for each new mesh, and little for each mesh.
Status set_positions(SceneDescription& scene, std::span<const NodeChange> changes,
                     std::size_t sampled, const NodeNumbers& numbers, const HeldMeshes& held,
                     PosedMeshes& posed);

/// Removes meshes that no instance has. Returns false, and removes none, if all of them are held;
/// else all meshes may have other numbers.
bool remove_unused_meshes(SceneDescription& scene, const HeldMeshes& held = {});
/// By mesh: true if an instance has it.
std::vector<bool> used_meshes(const SceneDescription& scene);
/// Sets the counts of triangles that are not finite or have no area to those of the used meshes.
void count_flat_triangles(SceneDescription& scene);

}  // namespace sightline

// Tests: tests/unit/run/moved_test.cpp
