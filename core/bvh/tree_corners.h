#pragma once
/// TreeCorners: the corners of a mesh's triangle in the space of a tree, and whether the tree needs
/// the triangle.

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// The result of tree_corners.
struct TreeCorners {
  std::array<Vec3d, 3> at;  ///< the corners, if usable
  /// False for a triangle that nothing can hit under any matrix: a corner is not finite in the
  /// tree's space, or two corners are equal. `at` is then unspecified.
  bool usable = false;
};

/// Maps the corners of a triangle by world_from_mesh; null leaves them in the mesh's own space.
/// Precondition: `triangle` is below mesh.triangle_count().
inline TreeCorners tree_corners(const MeshView& mesh, std::uint32_t triangle,
                                const Affine* world_from_mesh) {
  TreeCorners corners;
  const auto index = mesh.indices.corners(triangle);
  const Vec3f& a = mesh.positions[index[0]];
  const Vec3f& b = mesh.positions[index[1]];
  const Vec3f& c = mesh.positions[index[2]];
  // Equal corners stay equal under every matrix; unequal ones in a line need not stay in it.
  if (a == b || b == c || c == a) return corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3f& p = mesh.positions[index[k]];
    corners.at[k] =
        world_from_mesh != nullptr
            ? world_from_mesh->apply(p)
            : Vec3d{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
    if (!is_finite(corners.at[k])) return corners;
  }
  corners.usable = true;
  return corners;
}

}  // namespace sightline

// Tests: tests/unit/bvh/triangle_tree_test.cpp
