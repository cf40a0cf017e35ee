#pragma once
/// A tree over the triangles of one mesh, in the mesh's space or in the world's, or over the
/// triangles of several placed meshes.

#include <cstdint>
#include <span>
#include <vector>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// `world_from_mesh` null: boxes around the mesh's own triangles. Otherwise around the world
/// triangles. Leaves hold the mesh's float32 corners in both cases. Triangles with a corner that is
/// not finite in the tree's space, or with two equal corners, are left out: nothing can hit them
/// under any matrix. Returns an empty tree if cancelled; large trees poll the flag at intervals.
/// Precondition: at most kMaxTriangles.
WideTree build_triangle_tree(const MeshView& mesh, const Affine* world_from_mesh,
                             TreeQuality quality, const CancelFlag* cancel = nullptr);

/// Only of these triangles of the mesh, by which leaves call them.
WideTree build_triangle_tree(const MeshView& mesh, std::span<const std::uint32_t> triangles,
                             const Affine* world_from_mesh, TreeQuality quality,
                             const CancelFlag* cancel = nullptr);

/// A mesh where its triangles stand in a tree.
struct TreePart {
  MeshView mesh;
  const Affine* world_from_mesh = nullptr;  ///< as in build_triangle_tree
};

/// Around the triangles of all parts; a leaf block belongs to one part, whose index is its
/// `placement`. Precondition: at most kMaxTriangles in all.
WideTree build_triangle_tree(std::span<const TreePart> parts, TreeQuality quality,
                             const CancelFlag* cancel = nullptr);

/// The triangles of several parts numbered one after the other.
class PartNumbers {
 public:
  explicit PartNumbers(std::span<const TreePart> parts);

  struct Place {
    std::uint32_t part;
    std::uint32_t triangle;
  };
  std::uint32_t count() const { return ends_.back(); }
  std::uint32_t number(Place place) const { return begin(place.part) + place.triangle; }
  std::uint32_t part_of(std::uint32_t number) const;
  Place place_of(std::uint32_t number) const {
    const std::uint32_t part = part_of(number);
    return {part, number - begin(part)};
  }

 private:
  std::uint32_t begin(std::uint32_t part) const { return part == 0 ? 0 : ends_[part - 1]; }
  std::vector<std::uint32_t> ends_;  ///< one for each part
};

inline constexpr std::uint64_t kMaxTriangles =
    (1ull << 34) / (sizeof(LeafBlock) + sizeof(WideNode));
static_assert(kMaxTriangles <= LeafBlock::kTriangles);

/// The power of two by which coordinates within `bounds` are multiplied so that float32 boxes are
/// precise: 0 for ordinary scenes. `bounds` are finite and not empty.
int choose_scale_exponent(const Box3d& bounds);

}  // namespace sightline
