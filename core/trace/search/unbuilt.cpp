#include "core/trace/search/unbuilt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/rounding.h"
#include "core/query/sweep_batch.h"
#include "core/trace/ray_setup.h"
#include "core/trace/search/box_distance.h"
#include "core/trace/search/box_region.h"
#include "core/trace/search/tree_sweep.h"

namespace sightline {

namespace {

/// Where the ray enters and leaves each child; it meets those with enter <= leave. The slabs of
/// slabs-inl.h; a NaN among the planes excludes nothing.
struct Slabs {
  std::array<float, kArity> enter, leave;
};

/// Up to `limit`. The compiler makes vectors of the loops over the children.
Slabs slabs_of(const WideNode& node, const BoxRay& ray, float limit) {
  const float* const planes = &node.lower[0][0];
  Slabs slabs;
  slabs.enter.fill(ray.tau_min);
  slabs.leave.fill(limit);
  for (std::size_t k = 0; k < 3; ++k) {
    const float* const near = planes + ray.near_row[k];
    const float* const far = planes + (BoxRay::kBothRows[k] ^ ray.near_row[k]);
    const float near_origin = ray.near_origin[k], near_inverse = ray.near_inverse[k];
    const float far_origin = ray.far_origin[k], far_inverse = ray.far_inverse[k];
    for (std::size_t i = 0; i < kArity; ++i) {
      const float enter = (near[i] - near_origin) * near_inverse;
      const float leave = (far[i] - far_origin) * far_inverse;
      slabs.enter[i] = enter > slabs.enter[i] ? enter : slabs.enter[i];
      slabs.leave[i] = leave < slabs.leave[i] ? leave : slabs.leave[i];
    }
  }
  return slabs;
}

/// A node above the root, which may be a leaf and then has no box of its own.
WideNode above_root(const SceneTree& tree) {
  WideNode node{};
  std::fill(node.child + 1, node.child + kArity, ChildRef::kEmpty);
  const double scale = std::ldexp(1.0, tree.top.scale_exponent);
  for (int k = 0; k < 3; ++k) {
    node.lower[k][0] = float_below(tree.bounds.min[k] * scale);
    node.upper[k][0] = float_above(tree.bounds.max[k] * scale);
  }
  node.child[0] = tree.top.root;
  return node;
}

}  // namespace

UnbuiltNodes::UnbuiltNodes(const SceneView& scene)
    : tree_(scene.tree()), marked_(scene.tree().top.arena.used() / Arena::kGranule) {
  if (tree_.unbuilt_count > 0 && tree_.top.root != ChildRef::kEmpty) mark(tree_.top.root);
}

bool UnbuiltNodes::has(std::uint32_t ref) const { return marked_[ChildRef::granule(ref)]; }

bool UnbuiltNodes::mark(std::uint32_t ref) {
  bool has_unbuilt = false;
  if (ChildRef::is_leaf(ref)) {
    for (const LeafBlock& block : tree_.top.blocks(ref)) {
      for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
        const std::uint32_t tree = tree_.placements[block.triangle(lane)].tree;
        has_unbuilt = has_unbuilt || tree_.is_unbuilt(tree);
      }
    }
  } else {
    for (const std::uint32_t child : tree_.top.node(ref).child) {
      if (child != ChildRef::kEmpty && mark(child)) has_unbuilt = true;
    }
  }
  marked_[ChildRef::granule(ref)] = has_unbuilt;
  return has_unbuilt;
}

UnbuiltTrees::UnbuiltTrees(const SceneView& scene, const UnbuiltNodes* nodes)
    : tree_(scene.tree()), nodes_(nodes), above_(above_root(scene.tree())) {}

template <class Found>
void UnbuiltTrees::unbuilt_of(std::uint32_t leaf, Found found) const {
  for (const LeafBlock& block : tree_.top.blocks(leaf)) {
    for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
      const std::uint32_t tree = tree_.placements[block.triangle(lane)].tree;
      if (tree_.is_unbuilt(tree)) found(tree);
    }
  }
}

/// found(tree, near) returns up to where boxes are of interest from then on, in units of the top.
template <class Found>
void UnbuiltTrees::walk(const Ray& ray, double t, Found found) {
  if (tree_.unbuilt_count == 0 || tree_.top.root == ChildRef::kEmpty) return;
  const AnchoredRay anchored = anchor_ray(ray, tree_.bounds);
  const BoxRay box = make_box_ray(anchored, tree_.top.scale_exponent);
  const Interval end = t < ray.tmax ? anchored.tau_of(t) : anchored.tau_max;
  walk(box, box.limit(end.high), found);
}

template <class Found>
void UnbuiltTrees::walk(const BoxRay& box, float limit, Found found) {
  waiting_.clear();
  const Slabs first = slabs_of(above_, box, limit);
  if (first.enter[0] <= first.leave[0]) waiting_.push_back({tree_.top.root, first.enter[0]});
  while (!waiting_.empty()) {
    const Waiting next = waiting_.back();
    waiting_.pop_back();
    if (next.near > limit) continue;
    if (ChildRef::is_leaf(next.ref)) {
      unbuilt_of(next.ref, [&](std::uint32_t tree) { limit = found(tree, next.near, limit); });
      continue;
    }
    const WideNode& node = tree_.top.node(next.ref);
    const Slabs slabs = slabs_of(node, box, limit);
    // Far to near, so that the nearest is visited next.
    for (std::size_t i = 0; i < kArity; ++i) {
      const std::size_t child = node.order[box.octant] >> (3 * i) & 7u;
      if (!(slabs.enter[child] <= slabs.leave[child])) continue;
      const std::uint32_t ref = node.child[child];
      if (ref == ChildRef::kEmpty || skips(ref)) continue;
      waiting_.push_back({ref, slabs.enter[child]});
    }
  }
}

void PacketBounds::include(const Ray& ray, double t) {
  for (int k = 0; k < 3; ++k) {
    origin_min[k] = std::min(origin_min[k], ray.origin[k]);
    origin_max[k] = std::max(origin_max[k], ray.origin[k]);
    direction_min[k] = std::min(direction_min[k], ray.direction[k]);
    direction_max[k] = std::max(direction_max[k], ray.direction[k]);
  }
  t_min = std::min(t_min, ray.tmin);
  t_max = std::max(t_max, std::min(ray.tmax, std::nextafter(t, kInf)));
}

/// A form of all rays of a packet for trees in world units. Its tau is t: enter is at most, and
/// leave at least, that of any ray, if that is not negative. The bounds of both inverses cover a
/// subtraction and a product, each off by 2^-24 of its result at most. Products too small for that
/// are rounded alike on both sides, and rounding is monotonic. Products that overflow are infinite
/// on both sides; 0 times infinity is NaN and excludes nothing. Precondition: t_min >= 0.
static BoxRay box_ray_of(const PacketBounds& packet) {
  constexpr double kLess = 1 - 0x1p-22, kMore = 1 + 0x1p-22;
  BoxRay box{};
  std::array<std::uint32_t, 3> is_negative{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<int>(k);
    const double low = packet.direction_min[axis], high = packet.direction_max[axis];
    // Both signs: a slab excludes nothing.
    float nearest_origin = kInfF, farthest_origin = -kInfF, slow = 1, fast = 1;
    if (low >= 0 || high <= 0) {
      const double least = std::min(std::abs(low), std::abs(high));
      const double most = std::max(std::abs(low), std::abs(high));
      slow = float_below(1 / most * kLess);
      fast = float_above(1 / least * kMore);
      nearest_origin = float_above(packet.origin_max[axis]);
      farthest_origin = float_below(packet.origin_min[axis]);
      if (low < 0) {
        is_negative[k] = 1;
        std::swap(nearest_origin, farthest_origin);
        slow = -slow;
        fast = -fast;
      }
    }
    box.near_origin[k] = nearest_origin;
    box.far_origin[k] = farthest_origin;
    box.near_inverse[k] = slow;
    box.far_inverse[k] = fast;
  }
  box.set_octant(is_negative[0], is_negative[1], is_negative[2]);
  box.tau_min = float_below(packet.t_min);
  return box;
}

bool UnbuiltTrees::is_clear(const PacketBounds& packet) {
  if (tree_.unbuilt_count == 0 || tree_.top.root == ChildRef::kEmpty) return true;
  if (!(packet.t_min <= packet.t_max)) return true;
  if (packet.t_min < 0 || tree_.top.scale_exponent != 0) return false;
  bool clear = true;
  walk(box_ray_of(packet), float_above(packet.t_max), [&](std::uint32_t, float, float) {
    clear = false;
    return -1.0f;
  });
  return clear;
}

std::uint32_t UnbuiltTrees::nearest(const Ray& ray, double t) {
  std::uint32_t nearest = kNone;
  float nearest_near = std::numeric_limits<float>::infinity();
  walk(ray, t, [&](std::uint32_t tree, float near, float limit) {
    if (nearest != kNone && near >= nearest_near) return limit;
    nearest = tree;
    nearest_near = near;
    return near < limit ? near : limit;
  });
  return nearest;
}

void UnbuiltTrees::met(const Ray& ray, std::vector<std::uint32_t>& trees) {
  walk(ray, std::numeric_limits<double>::infinity(), [&](std::uint32_t tree, float, float limit) {
    trees.push_back(tree);
    return limit;
  });
}

std::uint32_t UnbuiltTrees::nearest_to(const Vec3d& point, double distance) {
  std::uint32_t nearest = kNone;
  if (tree_.unbuilt_count == 0 || tree_.top.root == ChildRef::kEmpty) return nearest;
  const TreePoint from = world_point(tree_.top, point);
  double limit = from.square_within(distance);
  std::vector<std::pair<std::uint32_t, double>> stack{{tree_.top.root, 0}};
  while (!stack.empty()) {
    const auto [ref, square] = stack.back();
    stack.pop_back();
    if (square > limit || (nearest != kNone && square >= limit)) continue;
    if (ChildRef::is_leaf(ref)) {
      unbuilt_of(ref, [&, near = square](std::uint32_t tree) {
        nearest = tree;
        limit = near;
      });
      continue;
    }
    const WideNode& node = tree_.top.node(ref);
    const std::array<double, kArity> squares = square_distances(node, from);
    for (std::size_t i = 0; i < kArity; ++i) {
      if (node.child[i] != ChildRef::kEmpty && squares[i] <= limit && !skips(node.child[i]))
        stack.emplace_back(node.child[i], squares[i]);
    }
  }
  return nearest;
}

/// Those below children whose bits are in children(node).
template <class Children>
void UnbuiltTrees::gather(Children children, std::vector<std::uint32_t>& trees) {
  waiting_.clear();
  if ((children(above_) & 1u) != 0) waiting_.push_back({tree_.top.root, 0});
  while (!waiting_.empty()) {
    const std::uint32_t ref = waiting_.back().ref;
    waiting_.pop_back();
    if (ChildRef::is_leaf(ref)) {
      unbuilt_of(ref, [&](std::uint32_t tree) { trees.push_back(tree); });
      continue;
    }
    const WideNode& node = tree_.top.node(ref);
    const unsigned mask = children(node);
    for (std::size_t child = 0; child < kArity; ++child) {
      if ((mask >> child & 1u) == 0 || skips(node.child[child])) continue;
      waiting_.push_back({node.child[child], 0});
    }
  }
}

void UnbuiltTrees::touched(const BoxBatch& boxes, std::size_t i,
                           std::vector<std::uint32_t>& trees) {
  if (tree_.unbuilt_count == 0 || tree_.top.root == ChildRef::kEmpty) return;
  TreeRegion region;
  boxes.visit(i, [&](const auto& box) { region = world_region(tree_.top, box); });
  gather([&](const WideNode& node) { return overlapped_children(node, region); }, trees);
}

void UnbuiltTrees::swept(const SweepBatch& sweeps, std::size_t i,
                         std::vector<std::uint32_t>& trees) {
  if (tree_.unbuilt_count == 0 || tree_.top.root == ChildRef::kEmpty) return;
  const SweptBounds bounds =
      sweeps.visit(i, [&](const auto& shape) { return bounds_of(sweeps.path(i), shape); });
  const TreeSweep sweep = sweep_over(tree_.top, bounds.path, bounds.extent, tree_.bounds);
  gather(
      [&](const WideNode& node) {
        unsigned mask = 0;
        for (std::size_t child = 0; child < kArity; ++child) {
          if (node.child[child] == ChildRef::kEmpty) continue;
          const TreeSweep::Times times =
              sweep.times(node, child, bounds.path.tmin, bounds.path.tmax);
          if (times.enter <= times.leave) mask |= 1u << child;
        }
        return mask;
      },
      trees);
}

}  // namespace sightline
