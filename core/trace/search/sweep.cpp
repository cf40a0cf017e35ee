#include "core/trace/search/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/geometry/rounding.h"
#include "core/geometry/triangle_distance.h"
#include "core/trace/leaf_triangle.h"

namespace sightline {

namespace {

constexpr double kU = 0x1p-53;
/// Nodes between two looks at the clock: some microseconds.
constexpr std::uint64_t kNodesPerLook = 64;

Vec3d extent_of(const SweptSphere& sphere) { return {sphere.radius, sphere.radius, sphere.radius}; }
Vec3d extent_of(const SweptBox& box) { return box.half; }

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
  Vec3d extent;
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
    if constexpr (std::is_same_v<Shape, SweptSphere>) {
      std::array<Vec3d, 2> ends;
      double slack = 0;
      for (int k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < 2; ++i) {
          const double step = (i == 0 ? times.enter : times.leave) * path.direction[k];
          ends[i][k] = path.origin[k] + step;
          slack = std::max(slack, std::fabs(path.origin[k]) + std::fabs(step));
        }
      }
      const double low_distance = distance_range(ends, corners_of(t)).low;
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
  if (++looks_ % kNodesPerLook == 0 && deadline_.passed()) stopped_ = true;
  return stopped_;
}

bool Sweeps::counts_at_all(TriangleId id) const {
  return resolved_ == nullptr ||
         resolved_->sides[resolved_->first[id.instance] + scene_.scene().primitive_of(id)] != 0;
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
void Sweeps::look_at_leaf(const Placement& entered, const LeafBlock* block, std::uint32_t blocks,
                          Search<Shape>& search) {
  const TreeSweep world = world_sweep(search.path, search.extent, scene_.tree().bounds);
  for (const LeafBlock* end = block + blocks; block != end; ++block) {
    ++counts_.blocks;
    const Placement& placement = (&entered)[block->placement()];
    for (std::uint32_t lane = 0; lane < block->lane_count() && !search.is_done(); ++lane) {
      const Triangle triangle = world_triangle(placement, *block, lane);
      const TriangleId id{placement.instance, block->triangle(lane)};
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
  const TreeSweep sweep =
      sweep_in(tree, placement, search.path, search.extent, scene_.tree().bounds, latest);
  walk_tree(tree, sweep, search, [&](std::uint32_t leaf) {
    look_at_leaf(placement, tree.blocks(leaf), ChildRef::blocks(leaf), search);
  });
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
  const TreeSweep::Times near = world_sweep(search.path, search.extent, tree.bounds)
                                    .times(low, high, search.path.tmin, search.path.tmax);
  if (near.enter > near.leave) return;
  search.first = near.enter;
  search.last = near.leave;
  if (tree.entries == 1) return enter(tree.placements[0], search);
  const TreeSweep over = sweep_over(tree.top, search.path, search.extent, tree.bounds);
  walk_tree(tree.top, over, search, [&](std::uint32_t leaf) {
    const LeafBlock* block = tree.top.blocks(leaf);
    for (const LeafBlock* end = block + ChildRef::blocks(leaf); block != end; ++block) {
      for (std::uint32_t lane = 0; lane < block->lane_count() && !stopped_ && !search.is_done();
           ++lane) {
        enter(tree.placements[block->triangle(lane)], search);
      }
    }
  });
}

void Sweeps::find(const SweepBatch& sweeps, std::size_t i, bool any, HitBatch& hits) {
  sweeps.visit(i, [&](const auto& shape) {
    Search<std::decay_t<decltype(shape)>> search{sweeps.path(i), shape, extent_of(shape), any, 0, 0,
                                                 std::nullopt,   {}};
    run(search);
    hits.t[i] = search.best ? search.best->rounded() : kInfD;
    hits.instance[i] = search.best ? search.id.instance : kNone;
    hits.triangle[i] = search.best ? search.id.triangle : kNone;
  });
}

Vec3d position_of_contact(const Scene& scene, const SweepBatch& sweeps, std::size_t i,
                          TriangleId id) {
  const Triangle triangle = scene.world_triangle(id);
  const SweepPath path = sweeps.path(i);
  return sweeps.visit(i, [&](const auto& shape) {
    using Contact = typename ContactOf<std::decay_t<decltype(shape)>>::Type;
    const auto contact = Contact::first(path, shape, triangle);
    return contact ? contact->position(path, shape, triangle) : Vec3d{};
  });
}

}  // namespace sightline
