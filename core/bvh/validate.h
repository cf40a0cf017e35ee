#pragma once
/// Validates a tree: proves that it loses no triangle, and that a kernel may traverse it without
/// further checks. Used for every tree that is read from a file, and in tests.
///
/// An accepted tree has these properties:
/// - Every reference is inside the arena. Every node and every leaf is reached exactly once, and
///   the arena holds nothing else. Its last cache line is empty.
/// - Boxes are finite and ordered, each inside the box that its parent stores for it. Empty
///   children are never hit. Every octant's order names every child.
/// - Every triangle is in exactly one leaf, with the corners of the mesh, inside of its leaf's box.
/// - Units, bounds, counts and depth agree with the content of the arena.
///
/// Laws    The tree is not trusted: an element is read only after its place is known to be inside
///         of the arena, and there is no recursion. Mesh and placements are trusted.
/// Errors  kMalformed, TREE_INVALID; the message names the node by its granule in the arena. Throws
///         std::bad_alloc.
/// Cost    Time linear in the sizes of tree and mesh; memory of a bit per granule and a bit per
///         triangle.

#include <span>

#include "core/base/result.h"
#include "core/bvh/scene_tree.h"
#include "core/bvh/triangle_tree.h"

namespace sightline {

/// Validates a tree of build_triangle_tree(mesh, world_from_mesh). A null world_from_mesh: the tree
/// is in mesh space.
Status validate_triangle_tree(const WideTree& tree, const MeshView& mesh,
                              const Affine* world_from_mesh);
/// Validates a tree of build_triangle_tree(parts): every leaf block has triangles of one part, and
/// names it. Messages name triangles by their PartNumbers.
Status validate_triangle_tree(const WideTree& tree, std::span<const TreePart> parts);

/// Validates SceneTree::top. `placed` are the world bounds of the entries, finite and not empty.
Status validate_top_tree(const WideTree& tree, std::span<const Box3d> placed);

}  // namespace sightline
