#pragma once
/// Builds a tree over the triangles of one mesh, in mesh space or world space, or over the
/// triangles of several placed meshes. All builders are parallel; the tree does not depend on the
/// number of threads. They throw std::bad_alloc. `cancel` may be null.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/bvh/scene_tree.h"
#include "core/bvh/split.h"

namespace sightline {

/// Builds a tree over all triangles of a mesh. With a null world_from_mesh its boxes are around the
/// mesh's own triangles, else around the world triangles. Leaves hold the mesh's float32 corners in
/// both cases. Triangles with a corner that is not finite in the tree's space, or with two equal
/// corners, are left out: nothing can hit them under any matrix. Returns an empty tree (root
/// kEmpty) if cancelled; large trees poll the flag at intervals. Precondition: the mesh has at most
/// kMaxTriangles.
WideTree build_triangle_tree(const MeshView& mesh, const Affine* world_from_mesh,
                             TreeQuality quality, const CancelFlag* cancel = nullptr);

/// A mesh and the map from its space into the space of a tree. Refers to the mesh's arrays, to the
/// map and to the runs, which must outlive it.
struct TreePart {
  MeshView mesh;
  const Affine* world_from_mesh = nullptr;  ///< null: the mesh's own space is that of the tree
  /// The triangles of the tree, by ascending number and without overlap; empty: all of the mesh.
  /// Only the part of a tree with a single part may have runs.
  std::span<const TriangleRun> runs = {};
};

/// Builds a tree around the triangles of all parts. A leaf block has triangles of one part, by
/// their numbers in its mesh; LeafBlock::placement is the index of that part. Precondition: at
/// least one part, fewer than LeafBlock::kPlacements, with at most kMaxTriangles in all.
WideTree build_triangle_tree(std::span<const TreePart> parts, TreeQuality quality,
                             const CancelFlag* cancel = nullptr);

/// Numbers the triangles of several parts consecutively: first all of part 0, then all of part 1,
/// and so on. Refers to the runs of the parts.
class PartNumbers {
 public:
  /// Precondition: there is at least one part.
  explicit PartNumbers(std::span<const TreePart> parts);

  /// A triangle of a part: the index of the part, and the number in the part's mesh.
  struct Place {
    std::uint32_t part = 0;
    std::uint32_t triangle = 0;
  };
  /// The number of triangles of all parts.
  std::uint32_t count() const { return ends_.back(); }
  /// The number of a triangle; empty if the runs of the part leave it out. Precondition: the part
  /// exists, and its mesh has the triangle.
  std::optional<std::uint32_t> number(Place place) const;
  /// The part of a number. Precondition: number < count().
  std::uint32_t part_of(std::uint32_t number) const;
  /// The triangle of a number. Precondition: number < count().
  Place place_of(std::uint32_t number) const;
  /// How many numbers from this one on are of triangles that follow each other in one part; at
  /// least 1. Precondition: number < count().
  std::uint32_t stretch(std::uint32_t number) const;
  /// True if triangles of part 0 may be too far apart for one leaf block (LeafBlock::fit).
  bool spans_far() const;

 private:
  std::uint32_t begin(std::uint32_t part) const { return part == 0 ? 0 : ends_[part - 1]; }
  std::vector<std::uint32_t> ends_;  ///< for each part, the number after its last triangle
  std::span<const TriangleRun> runs_;
  std::vector<std::uint32_t> run_ends_;  ///< for each run, the number after its last triangle
};

/// A tree of at most 16 GiB can hold this many triangles or entries.
inline constexpr std::uint64_t kMaxTriangles =
    (1ull << 34) / (LeafBlock::kMostGranules * Arena::kGranule + sizeof(WideNode));
static_assert(kTreeTriangles <= kMaxTriangles && kMaxTriangles <= LeafBlock::kTriangles);
static_assert(kTreeTriangles <= LeafBlock::kNear);

/// Returns the exponent e such that float32 boxes are precise for coordinates that are multiplied
/// by 2^e; 0 for ordinary scenes, whose largest coordinate is between 2^-40 and 2^41. `bounds` are
/// the finite bounds of all coordinates and not empty.
int choose_scale_exponent(const Box3d& bounds);

}  // namespace sightline
