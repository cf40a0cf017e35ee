#pragma once
/// TreeSweep: a swept shape as a line against enlarged boxes of a tree, with which the search skips
/// boxes. Intervals of t may be too long, never too short; triangles are decided exactly, in world
/// space. Proofs: docs/explanation/exactness-sweeps.md.

#include <array>

#include "core/bvh/scene_tree.h"
#include "core/geometry/box_sweep.h"
#include "core/geometry/capsule_sweep.h"
#include "core/geometry/sweep_path.h"

namespace sightline {

/// The line of the shape's centre in the units of a tree (wide_tree.h), with the t of the path.
/// Boxes are enlarged by `reach`: the extent of the shape on each axis plus all error bounds.
struct TreeSweep {
  std::array<double, 3> origin{}, direction{}, reach{};

  /// An interval of t, empty if enter > leave.
  struct Times {
    double enter, leave;
  };
  /// An interval that contains all t in [tmin, tmax] at which the shape may touch something in the
  /// box from `low` to `high`, in tree units.
  Times times(const std::array<double, 3>& low, const std::array<double, 3>& high, double tmin,
              double tmax) const;
  /// The interval for the box of child i of a node.
  Times times(const WideNode& node, std::size_t i, double tmin, double tmax) const;
};

/// A box that contains a swept shape at every t: its centre moves along `path`, and it extends by
/// `extent` on each axis, which may be infinite.
struct SweptBounds {
  SweepPath path;
  Vec3d extent;
};
SweptBounds bounds_of(const SweepPath& path, const SweptCapsule& capsule);
SweptBounds bounds_of(const SweepPath& path, const SweptBox& box);

/// The sweep in world space, without the scale of a tree. `extent`: how far the shape extends from
/// its centre on each axis. `bounds` contain everything that boxes contain.
TreeSweep world_sweep(const SweepPath& path, const Vec3d& extent, const Box3d& bounds);
/// The sweep in the units of the tree of a placement; `latest` is a bound of |t| for all t that
/// matter.
TreeSweep sweep_in(const WideTree& tree, const Placement& placement, const SweepPath& path,
                   const Vec3d& extent, const Box3d& bounds, double latest);
/// The sweep in the units of the top tree.
TreeSweep sweep_over(const WideTree& top, const SweepPath& path, const Vec3d& extent,
                     const Box3d& bounds);

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
