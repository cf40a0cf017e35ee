#pragma once
/// A tree over the triangles of one mesh, in the mesh's space or in the world's.

#include "core/bvh/scene_tree.h"

namespace sightline {

/// `world_from_mesh` null: boxes around the mesh's own triangles. Else around the world triangles.
/// Leaves hold the mesh's float32 corners in both cases. Triangles with a corner that is not finite
/// in the tree's space, or with two equal corners, are left out: nothing can hit them under any
/// matrix. Precondition: at most kMaxTriangles.
WideTree build_triangle_tree(const MeshView& mesh, const Affine* world_from_mesh,
                             TreeQuality quality);

inline constexpr std::uint64_t kMaxTriangles =
    (1ull << 34) / (sizeof(LeafBlock) + sizeof(WideNode));

/// The power of two by which to multiply coordinates within `bounds` so that float32 boxes keep
/// their precision: 0 for ordinary scenes. `bounds` are finite and not empty.
int choose_scale_exponent(const Box3d& bounds);

}  // namespace sightline
