#include "core/trace/search/nearest_miss.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/geometry/rounding.h"
#include "core/geometry/triangle_distance.h"
#include "core/trace/counting_sides.h"
#include "core/trace/leaf_triangle.h"
#include "core/trace/search/tree_sweep.h"

namespace sightline {

namespace {

class MissSearch {
 public:
  MissSearch(const SceneView& scene, const Ray& ray, const ResolvedFilter* resolved,
             const Deadline& deadline)
      : scene_(scene),
        path_{ray.origin, ray.direction, ray.tmin, ray.tmax},
        resolved_(resolved),
        deadline_(deadline) {
    keep_what_is_near();
  }

  std::optional<NearestMiss> run() {
    const SceneTree& tree = scene_.tree();
    if (tree.bounds.empty()) return std::nullopt;
    if (tree.entries == 1) {
      enter(tree.placements[0]);
      return best_;
    }
    walk(
        tree.top, [&] { return sweep_over(tree.top, path_, extent(), tree.bounds); },
        [&](std::uint32_t leaf) {
          for (const LeafBlock& block : tree.top.blocks(leaf)) {
            for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane)
              enter(tree.placements[block.triangle(lane)]);
          }
        });
    return best_;
  }

 private:
  /// Points of the scene are nearest to the part of the line that is about as far from the foot of
  /// the bounds' middle as their corners are from that.
  void keep_what_is_near() {
    const Box3d& bounds = scene_.tree().bounds;
    double square = 0, along = 0, reach = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = path_.direction[k];
      square += d * d;
      along += d * (bounds.min[k] * 0.5 + bounds.max[k] * 0.5 - path_.origin[k]);
      reach += bounds.max[k] - bounds.min[k];
    }
    const double middle = along / square, part = reach / std::sqrt(square);
    if (!std::isfinite(middle) || !std::isfinite(part)) return;
    // The whole of it may lie beyond the limits.
    path_.tmin = std::clamp(middle - part, path_.tmin, path_.tmax);
    path_.tmax = std::clamp(middle + part, path_.tmin, path_.tmax);
    for (int k = 0; k < 3; ++k) {
      ends_[0][k] = path_.origin[k] + path_.tmin * path_.direction[k];
      ends_[1][k] = path_.origin[k] + path_.tmax * path_.direction[k];
    }
  }

  Vec3d extent() const {
    const double reach = best_ ? best_->distance.high : 0x1p1000;
    return {reach, reach, reach};
  }

  void enter(const Placement& placement) {
    const SceneTree& scene = scene_.tree();
    const WideTree& tree = *scene.trees[placement.tree];
    const double latest = std::max(std::fabs(path_.tmin), std::fabs(path_.tmax));
    walk(
        tree, [&] { return sweep_in(tree, placement, path_, extent(), scene.bounds, latest); },
        [&](std::uint32_t leaf) {
          for (const LeafBlock& block : tree.blocks(leaf))
            look_at((&placement)[block.placement()], block);
        });
  }

  /// Boxes near the line come first. make_sweep() grows boxes by what is the nearest by then.
  template <class MakeSweep, class Leaf>
  void walk(const WideTree& tree, MakeSweep make_sweep, Leaf leaf) {
    if (tree.root == ChildRef::kEmpty) return;
    std::vector<std::uint32_t> stack{tree.root};
    while (!stack.empty()) {
      const std::uint32_t ref = stack.back();
      stack.pop_back();
      if (ChildRef::is_leaf(ref)) {
        leaf(ref);
        continue;
      }
      if (++looks_ % 64 == 0 && deadline_.passed()) return;
      const TreeSweep sweep = make_sweep();
      const WideNode& node = tree.node(ref);
      std::vector<std::pair<double, std::uint32_t>> children;
      for (std::size_t i = 0; i < kArity; ++i) {
        if (node.child[i] == ChildRef::kEmpty) continue;
        const TreeSweep::Times times = sweep.times(node, i, path_.tmin, path_.tmax);
        if (times.enter <= times.leave) children.emplace_back(aside(sweep, node, i), node.child[i]);
      }
      std::sort(children.begin(), children.end(), std::greater<>());
      for (const auto& [distance, child] : children) stack.push_back(child);
    }
  }

  /// About how far the middle of a child is from the line.
  double aside(const TreeSweep& sweep, const WideNode& node, std::size_t i) const {
    std::array<double, 3> to;
    double along = 0, square = 0, length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      to[k] =
          0.5 * (static_cast<double>(node.lower[k][i]) + static_cast<double>(node.upper[k][i])) -
          sweep.origin[k];
      along += to[k] * sweep.direction[k];
      square += sweep.direction[k] * sweep.direction[k];
    }
    const double t = std::clamp(along / square, path_.tmin, path_.tmax);
    for (std::size_t k = 0; k < 3; ++k) {
      const double off = to[k] - t * sweep.direction[k];
      length += off * off;
    }
    return std::isnan(length) ? 0 : length;
  }

  void look_at(const Placement& placement, const LeafBlock& block) {
    for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
      const TriangleId id{placement.instance, block.triangle(lane)};
      const Triangle triangle = world_triangle(placement, block, lane);
      if (!is_finite(triangle) || !counts(id)) continue;
      const DistanceRange range = distance_range(ends_, corners_of(triangle));
      if (best_ && std::pair(best_->distance.high, best_->id) <= std::pair(range.high, id))
        continue;
      best_ = NearestMiss{id, range};
    }
  }

  bool counts(TriangleId id) const {
    return resolved_ == nullptr || counting_sides(scene_.scene(), *resolved_, id) != 0;
  }

  const SceneView& scene_;
  SweepPath path_;
  const ResolvedFilter* const resolved_;
  const Deadline& deadline_;
  std::uint64_t looks_ = 0;
  std::array<Vec3d, 2> ends_{};
  std::optional<NearestMiss> best_;
};

}  // namespace

std::optional<NearestMiss> nearest_miss(const SceneView& scene, const Ray& ray,
                                        const ResolvedFilter* resolved, const Deadline& deadline) {
  return MissSearch(scene, ray, resolved, deadline).run();
}

}  // namespace sightline
