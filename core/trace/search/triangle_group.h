#pragma once
/// TriangleGroup: selected triangles of a scene with a tree of their own, for questions about two
/// selections (Clearance). The trees of the scene contain other triangles as well.

#include <cstdint>
#include <vector>

#include "core/base/deadline.h"
#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"
#include "core/query/hit_filter.h"
#include "core/scene/scene.h"

namespace sightline {

/// A list of triangles and a binary tree over them. Immutable after construction. It takes about 75
/// bytes for each triangle.
class TriangleGroup {
 public:
  /// A node of the binary tree.
  struct Node {
    Box3d box;                           ///< the exact world bounds of its triangles
    TriangleId least;                    ///< the smallest id of its triangles
    std::uint32_t first = 0, count = 0;  ///< its triangles: [first, first + count)
    std::uint32_t child = 0;             ///< index of the first of two children; 0: a leaf
  };
  /// The most triangles of a leaf.
  static constexpr std::uint32_t kLeafMembers = 4;

  /// Makes a group of the triangles of the primitives of which `resolved` has any side. Leaves out
  /// triangles that have no area or a corner that is not finite, and hidden instances. `scene` must
  /// outlive the group. If the deadline passes, the group is incomplete and must not be used.
  /// Throws std::bad_alloc. Cost: n log n.
  TriangleGroup(const Scene& scene, const ResolvedFilter& resolved, const Deadline& deadline);

  bool empty() const { return members_.empty(); }
  std::uint32_t size() const { return static_cast<std::uint32_t>(members_.size()); }
  /// The node of an index. Node 0 is the root; there is none if the group is empty.
  const Node& node(std::uint32_t i) const { return nodes_[i]; }
  /// The id of the triangle of an index below size().
  TriangleId id(std::uint32_t i) const { return members_[i].id; }
  /// Its corners in world space. Cost: they are computed from the mesh.
  Triangle triangle(std::uint32_t i) const { return scene_.world_triangle(id(i)); }

 private:
  struct Member {
    TriangleId id;
    Vec3f middle;  ///< of the box of the triangle, rounded
  };
  void divide(std::uint32_t node);
  void bound(Node& node) const;

  const Scene& scene_;
  std::vector<Member> members_;
  std::vector<Node> nodes_;
};

}  // namespace sightline

// Tests: tests/unit/trace/clearance_test.cpp
