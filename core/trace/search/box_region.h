#pragma once
/// TreeRegion: a region in the units of one tree that contains every point of the scene that a
/// query box contains; the search skips boxes outside it. The region may be larger; triangles are
/// decided exactly, in world space.

#include <array>

#include "core/bvh/scene_tree.h"
#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/convex/point_hull.h"
#include "core/geometry/triangle_capsule.h"
#include "core/geometry/triangle_convex.h"
#include "core/geometry/triangle_sphere.h"

namespace sightline {

/// An axis-aligned box in tree units (wide_tree.h), intersected with slab_count slabs.
struct TreeRegion {
  std::array<float, 3> lower{}, upper{};
  /// A slab low <= normal . x <= high: for an oriented box in a tree with world boxes, and for the
  /// first planes of a convex region. Errors of evaluating it on boxes of the tree are included.
  struct Slab {
    std::array<double, 3> normal{};
    double low = 0, high = 0;
  };
  static constexpr int kMostSlabs = 8;
  std::array<Slab, kMostSlabs> slabs;
  int slab_count = 0;
};

/// Makes the region for a tree in world units: the top tree, or a tree with world boxes.
TreeRegion world_region(const WideTree& tree, const Box3d& box);
TreeRegion world_region(const WideTree& tree, const OrientedBox& box);
inline TreeRegion world_region(const WideTree& tree, const Sphere& sphere) {
  return world_region(tree, outer_bounds(sphere));
}
inline TreeRegion world_region(const WideTree& tree, const Capsule& capsule) {
  return world_region(tree, outer_bounds(capsule));
}
TreeRegion world_region(const WideTree& tree, const ConvexRegion& region);
inline TreeRegion world_region(const WideTree& tree, const PointHull& hull) {
  return world_region(tree, outer_bounds(hull));
}
inline TreeRegion world_region(const WideTree& tree, const ConvexHull& hull) {
  return world_region(tree, hull.bounds());
}
/// Makes the region for a tree in mesh units, entered through a placement with this space.
TreeRegion mapped_region(const WideTree& tree, const TreeSpace& space, const Box3d& box);
TreeRegion mapped_region(const WideTree& tree, const TreeSpace& space, const OrientedBox& box);
inline TreeRegion mapped_region(const WideTree& tree, const TreeSpace& space,
                                const Sphere& sphere) {
  return mapped_region(tree, space, outer_bounds(sphere));
}
inline TreeRegion mapped_region(const WideTree& tree, const TreeSpace& space,
                                const Capsule& capsule) {
  return mapped_region(tree, space, outer_bounds(capsule));
}
inline TreeRegion mapped_region(const WideTree& tree, const TreeSpace& space,
                                const ConvexHull& hull) {
  return mapped_region(tree, space, hull.bounds());
}

/// Makes the region for the tree of a placement.
template <class Box>
TreeRegion region_in(const WideTree& tree, const Placement& placement, const Box& box) {
  return placement.world_boxes ? world_region(tree, box)
                               : mapped_region(tree, placement.space, box);
}
TreeRegion region_in(const WideTree& tree, const Placement& placement, const ConvexRegion& region);

/// A bit set: bit i is set if child i may contain a point of the region.
unsigned overlapped_children(const WideNode& node, const TreeRegion& region);

/// An axis-aligned box that contains the oriented box; infinite on an axis where no better bound is
/// certain.
Box3d outer_bounds(const OrientedBox& box);

}  // namespace sightline

// Tests: tests/unit/trace/box_overlap_test.cpp
