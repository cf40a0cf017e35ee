#include "core/trace/search/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "core/geometry/rounding.h"
#include "core/geometry/triangle_distance.h"
#include "core/trace/counting_sides.h"
#include "core/trace/leaf_triangle.h"

namespace sightline {

namespace {

struct WaitingSweep {
  std::uint32_t ref;
  double enter;
};

}  // namespace

template <class Shape>
struct Sweeps::Search {
  using Contact = typename ContactOf<Shape>::Type;

  SweepPath path;
  Shape shape;
  SweptBounds bounds;
  bool any = false;
  // The part of the limits in which the shape is near the scene.
  double first = 0, last = 0;
  std::optional<Contact> best;
  TriangleId id;

  bool is_done() const { return any && best; }
  /// No float64 below any t that matters is above this.
  void shorten() { last = std::min(last, next_above(best->rounded())); }

  /// False where float64 is certain that the triangle is not met from first to last: by its bounds,
  /// and of a sphere by the distance from what its centre passes.
  bool may_meet(const TreeSweep& world, const Triangle& t) const {
    std::array<double, 3> low, high;
    for (int k = 0; k < 3; ++k) {
      low[static_cast<std::size_t>(k)] = std::min({t.v0[k], t.v1[k], t.v2[k]});
      high[static_cast<std::size_t>(k)] = std::max({t.v0[k], t.v1[k], t.v2[k]});
    }
    const TreeSweep::Times times = world.times(low, high, first, last);
    if (times.enter > times.leave) return false;
    if constexpr (std::is_same_v<Shape, SweptCapsule>) {
      // Both ends, where they are when they may first and last be near.
      std::array<Vec3d, 4> ends;
      double slack = 0;
      for (int k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < 4; ++i) {
          const double from = i < 2 ? path.origin[k] : shape.to[k];
          const double step = (i % 2 == 0 ? times.enter : times.leave) * path.direction[k];
          ends[i][k] = from + step;
          slack = std::max(slack, std::fabs(from) + std::fabs(step));
        }
      }
      const std::span all(ends);
      double low_distance = 0;
      if (shape.to == path.origin) {
        low_distance = distance_range(all.first(2), corners_of(t)).low;
      } else {
        low_distance = std::min(distance_range(all.first(3), corners_of(t)).low,
                                distance_range(all.last(3), corners_of(t)).low);
      }
      // Two roundings on each axis; NaN excludes nothing.
      if (low_distance > shape.radius + 8 * kU * (slack + shape.radius) + 0x1p-1000) return false;
    }
    return true;
  }

  void offer(TriangleId triangle_id, const Triangle& triangle) {
    std::optional<Contact> contact = Contact::first(path, shape, triangle);
    if (!contact) return;
    if (best) {
      const int order = compare(*contact, *best);
      if (order > 0 || (order == 0 && id < triangle_id)) return;
    }
    best = std::move(contact);
    id = triangle_id;
    shorten();
  }
};

bool Sweeps::out_of_time() {
  if (watch_.passed()) stopped_ = true;
  return stopped_;
}

bool Sweeps::counts_at_all(TriangleId id) const {
  return resolved_ == nullptr || counting_sides(scene_.scene(), *resolved_, id) != 0;
}

/// Boxes that are entered first come first.
template <class Shape, class Leaf>
void Sweeps::walk_tree(const WideTree& tree, const TreeSweep& sweep, Search<Shape>& search,
                       Leaf leaf) {
  if (tree.root == ChildRef::kEmpty) return;
  std::vector<WaitingSweep> stack{{tree.root, search.first}};
  while (!stack.empty() && !stopped_ && !search.is_done()) {
    const WaitingSweep next = stack.back();
    stack.pop_back();
    if (next.enter > search.last) continue;
    if (ChildRef::is_leaf(next.ref)) {
      leaf(next.ref);
      continue;
    }
    if (out_of_time()) return;
    ++counts_.nodes;
    const WideNode& node = tree.node(next.ref);
    const auto first = static_cast<std::ptrdiff_t>(stack.size());
    for (std::size_t i = 0; i < kArity; ++i) {
      if (node.child[i] == ChildRef::kEmpty) continue;
      const TreeSweep::Times times = sweep.times(node, i, search.first, search.last);
      if (times.enter <= times.leave) stack.push_back({node.child[i], times.enter});
    }
    std::sort(stack.begin() + first, stack.end(),
              [](const WaitingSweep& a, const WaitingSweep& b) { return a.enter > b.enter; });
  }
}

template <class Shape>
void Sweeps::look_at_leaf(const Placement& entered, LeafBlocks blocks, Search<Shape>& search) {
  const TreeSweep world =
      world_sweep(search.bounds.path, search.bounds.extent, scene_.tree().bounds);
  for (const LeafBlock& block : blocks) {
    ++counts_.blocks;
    const Placement& placement = (&entered)[block.placement()];
    for (std::uint32_t lane = 0; lane < block.lane_count() && !search.is_done(); ++lane) {
      const Triangle triangle = world_triangle(placement, block, lane);
      const TriangleId id{placement.instance, block.triangle(lane)};
      if (!is_finite(triangle) || !search.may_meet(world, triangle) || !counts_at_all(id)) continue;
      // What is decided exactly takes as long as many nodes.
      if (deadline_.passed()) {
        stopped_ = true;
        return;
      }
      ++counts_.decisions.exact_hits;
      search.offer(id, triangle);
    }
  }
}

template <class Shape>
void Sweeps::enter(const Placement& placement, Search<Shape>& search) {
  const WideTree& tree = *scene_.tree().trees[placement.tree];
  ++counts_.placements;
  const double latest = std::max(std::fabs(search.first), std::fabs(search.last));
  const TreeSweep sweep = sweep_in(tree, placement, search.bounds.path, search.bounds.extent,
                                   scene_.tree().bounds, latest);
  walk_tree(tree, sweep, search,
            [&](std::uint32_t leaf) { look_at_leaf(placement, tree.blocks(leaf), search); });
}

template <class Shape>
void Sweeps::run(Search<Shape>& search) {
  const SceneTree& tree = scene_.tree();
  if (tree.bounds.empty()) return;
  std::array<double, 3> low, high;
  for (int k = 0; k < 3; ++k) {
    low[static_cast<std::size_t>(k)] = tree.bounds.min[k];
    high[static_cast<std::size_t>(k)] = tree.bounds.max[k];
  }
  const TreeSweep::Times near = world_sweep(search.bounds.path, search.bounds.extent, tree.bounds)
                                    .times(low, high, search.path.tmin, search.path.tmax);
  if (near.enter > near.leave) return;
  search.first = near.enter;
  search.last = near.leave;
  if (tree.entries == 1) return enter(tree.placements[0], search);
  const TreeSweep over =
      sweep_over(tree.top, search.bounds.path, search.bounds.extent, tree.bounds);
  walk_tree(tree.top, over, search, [&](std::uint32_t leaf) {
    for (const LeafBlock& block : tree.top.blocks(leaf)) {
      for (std::uint32_t lane = 0; lane < block.lane_count() && !stopped_ && !search.is_done();
           ++lane) {
        enter(tree.placements[block.triangle(lane)], search);
      }
    }
  });
}

void Sweeps::find(const SweepBatch& sweeps, std::size_t i, bool any, HitBatch& hits) {
  sweeps.visit(i, [&](const auto& shape) {
    const SweepPath path = sweeps.path(i);
    Search<std::decay_t<decltype(shape)>> search{path, shape, bounds_of(path, shape), any,
                                                 0,    0,     std::nullopt,           {}};
    run(search);
    hits.t[i] = search.best ? search.best->rounded() : kInfD;
    hits.instance[i] = search.best ? search.id.instance : kNone;
    hits.triangle[i] = search.best ? search.id.triangle : kNone;
  });
}

HitDetail detail_of_contact(const Scene& scene, const SweepBatch& sweeps, std::size_t i,
                            TriangleId id) {
  constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  const Triangle triangle = scene.world_triangle(id);
  const SweepPath path = sweeps.path(i);
  return sweeps.visit(i, [&](const auto& shape) {
    using Contact = typename ContactOf<std::decay_t<decltype(shape)>>::Type;
    HitDetail detail;
    const auto contact = Contact::first(path, shape, triangle);
    if (!contact) return detail;
    detail.position = contact->position(path, shape, triangle);
    detail.normal =
        contact->normal(path, shape, triangle).value_or(Vec3d{kNoNumber, kNoNumber, kNoNumber});
    return detail;
  });
}

}  // namespace sightline
