#pragma once
/// How far a point is at least from the boxes of a tree. Conservative; triangles are decided in the
/// world, exactly. Proofs: docs/explanation/exactness-points.md.

#include <array>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// A point in the units of one tree.
struct TreePoint {
  std::array<double, 3> at{};
  /// By how much the point, or what a box holds, may be off on each axis.
  std::array<double, 3> margin{};
  /// Distances in the tree are at most this times those in the world.
  double stretch = 1;

  /// Boxes whose square distance is larger hold nothing that is within `distance` of the point, in
  /// scene units.
  double square_within(double distance) const;
};

/// For a tree in world units: that of the placements, or one with world boxes.
TreePoint world_point(const WideTree& tree, const Vec3d& point);
/// For a tree in mesh units, entered through a placement.
TreePoint mapped_point(const WideTree& tree, const TreeSpace& space, const Vec3d& point);

/// At most the square distances of the point from the eight children's boxes; of no child +inf.
std::array<double, kArity> square_distances(const WideNode& node, const TreePoint& point);

}  // namespace sightline

// Tests: tests/unit/trace/nearest_test.cpp
