#include "core/trace/search/nearest.h"

#include <algorithm>
#include <array>

#include "core/geometry/rounding.h"
#include "core/trace/counting_sides.h"
#include "core/trace/leaf_triangle.h"
#include "core/trace/search/box_distance.h"

namespace sightline {

namespace {

struct Waiting {
  std::uint32_t ref;
  double square;  ///< at most its square distance
};

}  // namespace

bool NearestTriangles::out_of_time() {
  if (watch_.passed()) stopped_ = true;
  return stopped_;
}

/// Nearest boxes first, until none is left that could hold something of interest.
template <class Leaf>
void NearestTriangles::walk_tree(const WideTree& tree, const TreePoint& point, Leaf leaf) {
  if (tree.root == ChildRef::kEmpty) return;
  std::vector<Waiting> stack{{tree.root, 0}};
  double limit = point.square_within(reach());
  while (!stack.empty() && !stopped_) {
    const Waiting next = stack.back();
    stack.pop_back();
    if (next.square > limit) continue;
    if (ChildRef::is_leaf(next.ref)) {
      leaf(next.ref);
      limit = point.square_within(reach());
      continue;
    }
    if (out_of_time()) return;
    ++counts_.nodes;
    const WideNode& node = tree.node(next.ref);
    const std::array<double, kArity> square = square_distances(node, point);
    const std::size_t first = stack.size();
    for (std::size_t i = 0; i < kArity; ++i) {
      if (square[i] > limit || node.child[i] == ChildRef::kEmpty) continue;
      stack.push_back({node.child[i], square[i]});
    }
    // The nearest is visited next.
    std::sort(stack.begin() + static_cast<std::ptrdiff_t>(first), stack.end(),
              [](const Waiting& a, const Waiting& b) { return a.square > b.square; });
  }
}

bool NearestTriangles::counts_at_all(TriangleId id) const {
  return resolved_ == nullptr || counting_sides(scene_.scene(), *resolved_, id) != 0;
}

bool NearestTriangles::is_within(const NearTriangle& near) {
  if (near.range.high <= max_distance_) return true;
  if (near.range.low > max_distance_) return false;
  ++counts_.decisions.exact_compares;
  return compare(exact_distance(point_, near.triangle), max_distance_) <= 0;
}

bool NearestTriangles::comes_before(const NearTriangle& a, const NearTriangle& b) {
  if (a.range.high < b.range.low) return true;
  if (b.range.high < a.range.low) return false;
  // A shared corner or edge is the usual reason for equal distances.
  const CornerSet at_a = certain_nearest_edge(point_, a.triangle);
  const CornerSet at_b = at_a == 0 ? 0 : certain_nearest_edge(point_, b.triangle);
  if (at_b != 0 && corners_at(b.triangle, a.triangle, at_a) == at_b) return a.id < b.id;
  ++counts_.decisions.exact_compares;
  const int order = compare(exact_distance(point_, a.triangle), exact_distance(point_, b.triangle));
  return order != 0 ? order < 0 : a.id < b.id;
}

void NearestTriangles::offer(NearTriangle near) {
  if (near.range.low > reach() || !counts_at_all(near.id) || is_degenerate(near.triangle) ||
      !is_within(near)) {
    return;
  }
  const auto before = [&](const NearTriangle& a, const NearTriangle& b) {
    return comes_before(a, b);
  };
  const auto place = std::upper_bound(found_.begin(), found_.end(), near, before);
  if (found_.size() == count_) {
    if (place == found_.end()) return;
    std::move_backward(place, found_.end() - 1, found_.end());
    *place = near;
  } else {
    found_.insert(place, near);
  }
}

void NearestTriangles::look_at_leaf(const Placement& entered, LeafBlocks blocks) {
  for (const LeafBlock& block : blocks) {
    ++counts_.blocks;
    const Placement& placement = (&entered)[block.placement()];
    for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
      const Triangle triangle = world_triangle(placement, block, lane);
      if (!is_finite(triangle)) continue;
      const DistanceRange range = distance_range(point_, triangle);
      if (range.low > reach()) continue;
      offer({range, {placement.instance, block.triangle(lane)}, triangle});
    }
  }
}

void NearestTriangles::enter(const Placement& placement) {
  const WideTree& tree = *scene_.tree().trees[placement.tree];
  ++counts_.placements;
  const TreePoint point = placement.world_boxes ? world_point(tree, point_)
                                                : mapped_point(tree, placement.space, point_);
  walk_tree(tree, point, [&](std::uint32_t leaf) { look_at_leaf(placement, tree.blocks(leaf)); });
}

void NearestTriangles::find(const Vec3d& point, double max_distance, std::size_t count) {
  found_.clear();
  point_ = point;
  max_distance_ = max_distance;
  count_ = count;
  const SceneTree& tree = scene_.tree();
  if (tree.entries == 1) return enter(tree.placements[0]);
  walk_tree(tree.top, world_point(tree.top, point), [&](std::uint32_t leaf) {
    for (const LeafBlock& block : tree.top.blocks(leaf)) {
      for (std::uint32_t lane = 0; lane < block.lane_count() && !stopped_; ++lane) {
        enter(tree.placements[block.triangle(lane)]);
      }
    }
  });
}

void NearestTriangles::write(std::size_t first, HitBatch& hits) const {
  for (std::size_t k = 0; k < count_; ++k) {
    const bool is_there = k < found_.size();
    hits.t[first + k] = is_there ? exact_distance(point_, found_[k].triangle).rounded() : kInfD;
    hits.instance[first + k] = is_there ? found_[k].id.instance : kNone;
    hits.triangle[first + k] = is_there ? found_[k].id.triangle : kNone;
  }
}

HitDetail detail_of_nearest(const Scene& scene, const Vec3d& point, TriangleId id) {
  const NearestDetail near = nearest_detail(point, scene.world_triangle(id));
  return {near.detail.position, near.detail.normal, near.detail.u,
          near.detail.v,        near.detail.front,  near.on_edge};
}

}  // namespace sightline
