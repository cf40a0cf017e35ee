#pragma once
/// Lower bounds of the distance of a point from the boxes of a tree, with which the search for near
/// triangles skips boxes. Triangles are decided exactly, in world space. Proofs:
/// docs/explanation/exactness-points.md.

#include <array>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// A point in the units of one tree (wide_tree.h). Make it with world_point or mapped_point, pass
/// it to square_distances.
struct TreePoint {
  std::array<double, 3> at{};
  /// On each axis, a bound of the error of the point plus the distance by which triangles lie
  /// outside of their boxes.
  std::array<double, 3> margin{};
  /// A distance in tree units is at most `stretch` times the distance in world units.
  double stretch = 1;

  /// Returns the largest squared distance in tree units that matters: a box that is farther
  /// contains nothing within `distance`, in world units, of the point.
  double square_within(double distance) const;
};

/// Makes the point for a tree in world units: the top tree, or a tree with world boxes.
TreePoint world_point(const WideTree& tree, const Vec3d& point);
/// Makes the point for a tree in mesh units, entered through a placement with this space.
TreePoint mapped_point(const WideTree& tree, const TreeSpace& space, const Vec3d& point);

/// Lower bounds of the squared distances, in tree units, of the point from the boxes of the eight
/// children; +inf for an empty child.
std::array<double, kArity> square_distances(const WideNode& node, const TreePoint& point);

}  // namespace sightline

// Tests: tests/unit/trace/nearest_test.cpp
