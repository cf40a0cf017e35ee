#include "core/trace/search/tree_sweep.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/rounding.h"
#include "core/trace/bounds.h"
#include "core/trace/search/box_region.h"

namespace sightline {

namespace {

using bounds::kScaledUnderflow;
using bounds::kUnderflow;

void scale(const WideTree& tree, TreeSweep& sweep) {
  if (tree.scale_exponent == 0) return;
  const double factor = std::ldexp(1.0, tree.scale_exponent);
  for (std::size_t k = 0; k < 3; ++k) {
    sweep.origin[k] *= factor;
    // What vanishes is not nothing.
    const double along = sweep.direction[k] * factor;
    if (sweep.direction[k] != 0) sweep.direction[k] = along != 0 ? along : 0x1p-1074;
    sweep.reach[k] = sweep.reach[k] * factor + kScaledUnderflow;
  }
}

}  // namespace

TreeSweep::Times TreeSweep::times(const std::array<double, 3>& low,
                                  const std::array<double, 3>& high, double tmin,
                                  double tmax) const {
  Times times{tmin, tmax};
  for (std::size_t k = 0; k < 3; ++k) {
    const double below = (low[k] - reach[k]) - origin[k], above = (high[k] + reach[k]) - origin[k];
    const double d = direction[k];
    // A direction that may have vanished on the way into the tree, or numbers that are none,
    // exclude nothing but what lies beside the line.
    if (!(std::fabs(d) > 0x1p-1000)) {
      if (d == 0 && (below > 0 || above < 0)) return {kInfD, -kInfD};
      continue;
    }
    const double first = (d > 0 ? below : above) / d, last = (d > 0 ? above : below) / d;
    const double slack = 8 * kU * (std::fabs(first) + std::fabs(last)) + 0x1p-1060;
    if (first - slack > times.enter) times.enter = first - slack;
    if (last + slack < times.leave) times.leave = last + slack;
  }
  return times;
}

TreeSweep::Times TreeSweep::times(const WideNode& node, std::size_t i, double tmin,
                                  double tmax) const {
  std::array<double, 3> low, high;
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = static_cast<double>(node.lower[k][i]);
    high[k] = static_cast<double>(node.upper[k][i]);
  }
  return times(low, high, tmin, tmax);
}

SweptBounds bounds_of(const SweepPath& path, const SweptCapsule& capsule) {
  SweptBounds bounds{path, {capsule.radius, capsule.radius, capsule.radius}};
  if (capsule.to == path.origin) return bounds;
  for (int k = 0; k < 3; ++k) {
    const double a = path.origin[k], b = capsule.to[k], middle = a / 2 + b / 2;
    bounds.path.origin[k] = middle;
    const double reach = next_above(std::max(std::fabs(a - middle), std::fabs(b - middle)));
    bounds.extent[k] = next_above(reach + capsule.radius);
  }
  return bounds;
}

SweptBounds bounds_of(const SweepPath& path, const SweptBox& box) {
  if (!box.axes) return {path, box.half};
  const Box3d outer = outer_bounds(OrientedBox{path.origin, box.half, *box.axes});
  SweptBounds bounds{path, {}};
  for (int k = 0; k < 3; ++k) {
    bounds.extent[k] =
        next_above(std::max(outer.max[k] - path.origin[k], path.origin[k] - outer.min[k]));
  }
  return bounds;
}

TreeSweep world_sweep(const SweepPath& path, const Vec3d& extent, const Box3d& bounds) {
  TreeSweep sweep;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    sweep.origin[i] = path.origin[k];
    sweep.direction[i] = path.direction[k];
    const double largest =
        std::max(std::fabs(bounds.min[k]), std::fabs(bounds.max[k])) * (1 + 0x1p-20);
    // The two sums with a side of a box.
    sweep.reach[i] =
        extent[k] + 4 * kU * (largest + extent[k] + std::fabs(path.origin[k])) + kUnderflow;
  }
  return sweep;
}

TreeSweep sweep_over(const WideTree& top, const SweepPath& path, const Vec3d& extent,
                     const Box3d& bounds) {
  TreeSweep sweep = world_sweep(path, extent, bounds);
  scale(top, sweep);
  return sweep;
}

TreeSweep sweep_in(const WideTree& tree, const Placement& placement, const SweepPath& path,
                   const Vec3d& extent, const Box3d& bounds, double latest) {
  if (placement.world_boxes) return sweep_over(tree, path, extent, bounds);
  const TreeSpace& space = placement.space;
  TreeSweep sweep;
  for (std::size_t k = 0; k < 3; ++k) {
    double at = 0, along = 0, steps = 0, reach = 0, magnitude = 0;
    bool moves = false;
    for (int j = 0; j < 3; ++j) {
      const double n = space.inverse[k][j];
      if (n == 0) continue;
      const double step = n * path.direction[j];
      at += n * (path.origin[j] - space.translation[j]);
      along += step;
      steps += std::fabs(step);
      moves = moves || path.direction[j] != 0;
      reach += std::fabs(n) * extent[j];
      magnitude += std::fabs(n) * (std::fabs(path.origin[j]) + std::fabs(space.translation[j]) +
                                   extent[j] + latest * std::fabs(path.direction[j]));
    }
    const int axis = static_cast<int>(k);
    const double largest =
        std::max(std::fabs(tree.bounds.min[axis]), std::fabs(tree.bounds.max[axis])) *
        (1 + 0x1p-20);
    sweep.origin[k] = at;
    // What vanishes is not nothing.
    sweep.direction[k] = along == 0 && moves && steps < 0x1p-1000 ? 0x1p-1074 : along;
    sweep.reach[k] =
        reach + space.pad[k] + 16 * kU * (magnitude + largest + space.pad[k]) + kUnderflow;
  }
  scale(tree, sweep);
  return sweep;
}

}  // namespace sightline
