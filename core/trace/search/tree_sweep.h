#pragma once
/// A swept shape as the boxes of one tree see it. Conservative; triangles are decided in the world,
/// exactly. Proofs: docs/explanation/exactness-sweeps.md.

#include <array>

#include "core/bvh/scene_tree.h"
#include "core/geometry/sweep_path.h"

namespace sightline {

/// The times at which a line is within boxes. The boxes are grown by the extent of the shape on
/// each axis and by all error bounds.
struct TreeSweep {
  std::array<double, 3> origin{}, direction{}, reach{};

  struct Times {
    double enter, leave;  ///< enter <= leave, or nothing of it is met
  };
  /// Between these t at the most the shape may touch something in the box, within the limits.
  Times times(const std::array<double, 3>& low, const std::array<double, 3>& high, double tmin,
              double tmax) const;
  /// The times for child i of a node.
  Times times(const WideNode& node, std::size_t i, double tmin, double tmax) const;
};

/// In the world. `extent`: how far the shape reaches from its centre on each axis; `bounds`: all
/// that the boxes hold.
TreeSweep world_sweep(const SweepPath& path, const Vec3d& extent, const Box3d& bounds);
/// For the tree of a placement; `latest` is at least the magnitude of every t that matters.
TreeSweep sweep_in(const WideTree& tree, const Placement& placement, const SweepPath& path,
                   const Vec3d& extent, const Box3d& bounds, double latest);
/// The sweep through the tree over the placements.
TreeSweep sweep_over(const WideTree& top, const SweepPath& path, const Vec3d& extent,
                     const Box3d& bounds);

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
