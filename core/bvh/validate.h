#pragma once
/// Proves that a tree loses no triangle. A kernel may walk an accepted tree without further checks.
/// Used in tests, and for every tree that was read from a file.
///
/// Proved:
/// - Every reference is inside the arena. Every node and every leaf is reached exactly once, and
///   the arena holds nothing else.
/// - Boxes are finite and ordered, each inside the box that its parent stores for it. Empty
///   children are never hit. Every octant's order names every child.
/// - Every triangle is in exactly one leaf, with the mesh's own corners, inside its leaf's box.
/// - Units, bounds, counts and depth agree with the content.
///
/// Laws    The tree is hostile: nothing is read before its place is known to lie inside the arena,
///         and there is no recursion. Mesh and placements are trusted.
/// Errors  kMalformed, TREE_INVALID; the message names the node by its granule in the arena.
///         Throws std::bad_alloc.
/// Cost    Time linear in tree and mesh; a bit per granule and one per triangle.

#include <span>

#include "core/base/result.h"
#include "core/bvh/scene_tree.h"
#include "core/bvh/triangle_tree.h"

namespace sightline {

/// For what build_triangle_tree(mesh, world_from_mesh) made.
Status validate_triangle_tree(const WideTree& tree, const MeshView& mesh,
                              const Affine* world_from_mesh);
/// For what build_triangle_tree(parts) made: every block is of one part, and says which. Triangles
/// are named by their number in all parts, one after the other.
Status validate_triangle_tree(const WideTree& tree, std::span<const TreePart> parts);

/// For SceneTree::top over entries whose world triangles have these bounds, finite and not
/// empty.
Status validate_top_tree(const WideTree& tree, std::span<const Box3d> placed);

}  // namespace sightline
