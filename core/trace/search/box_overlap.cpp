#include "core/trace/search/box_overlap.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "core/geometry/exact_hit.h"
#include "core/geometry/triangle_box.h"
#include "core/geometry/triangle_within.h"
#include "core/trace/leaf_triangle.h"
#include "core/trace/search/box_region.h"

namespace sightline {

namespace {

constexpr auto kNoneLeft = [](std::uint32_t) { return false; };

template <class Box>
bool does_count(const Triangle& triangle, const Box& box, BoxRelation relation) {
  if (relation == BoxRelation::kIntersecting) return triangle_meets_box(triangle, box);
  return corners_within(triangle, box) && !is_degenerate(triangle);
}

/// Depth first over a tree, leaves as they come. `leaf` and `node` return false to end the walk.
template <class Leaf, class Node>
bool walk_tree(const WideTree& tree, const TreeRegion& region, Leaf leaf, Node node) {
  if (tree.root == ChildRef::kEmpty) return true;
  if (ChildRef::is_leaf(tree.root)) return leaf(tree.root);
  // Every level leaves at most seven siblings behind.
  std::vector<std::uint32_t> stack{tree.root};
  while (!stack.empty()) {
    const std::uint32_t ref = stack.back();
    stack.pop_back();
    if (ChildRef::is_leaf(ref)) {
      if (!leaf(ref)) return false;
      continue;
    }
    if (!node()) return false;
    const WideNode& children = tree.node(ref);
    const unsigned mask = overlapped_children(children, region);
    for (std::size_t i = kArity; i-- > 0;) {
      if ((mask & (1u << i)) != 0) stack.push_back(children.child[i]);
    }
  }
  return true;
}

}  // namespace

bool BoxOverlaps::out_of_time() {
  if (watch_.passed()) stopped_ = true;
  return stopped_;
}

/// False if the deadline has passed before the faces of a hull are found, which takes as long as many
/// nodes.
template <class Box>
bool BoxOverlaps::has_time_for(const Box&) {
  if constexpr (std::is_same_v<Box, PointHull>) stopped_ = stopped_ || deadline_.passed();
  return !stopped_;
}

/// `entered` is the placement whose tree this is, or the first of those that share it. Returns what
/// the tree is to do next.
template <class Box, class Found, class Left>
BoxOverlaps::Next BoxOverlaps::decide_leaf(const Box& box, const Placement& entered,
                                           const WideTree& tree, std::uint32_t leaf, Found& found,
                                           Left& left) {
  Next next = Next::kOn;
  for (const LeafBlock& block : tree.blocks(leaf)) {
    // A triangle that many planes cut takes as long as many nodes.
    if (out_of_time()) return Next::kStop;
    const Placement& placement = (&entered)[block.placement()];
    if (left(placement.instance)) continue;
    next = Next::kOn;
    for (std::uint32_t lane = 0; lane < block.lane_count() && next == Next::kOn; ++lane) {
      ++counts_.triangles;
      if (!does_count(world_triangle(placement, block, lane), box, relation_)) continue;
      next = found(TriangleId{placement.instance, block.triangle(lane)});
    }
    if (next == Next::kStop) break;
  }
  return next;
}

/// Returns false to end the whole walk. A placement that is left early ends only its own.
template <class Box, class Found, class Left>
bool BoxOverlaps::walk_placement(const Box& box, const Placement& placement, Found& found,
                                 Left& left) {
  const SceneTree& scene = scene_.tree();
  const WideTree& tree = *scene.trees[placement.tree];
  const bool shares_tree =
      &placement == &scene.placements[scene.entries - 1] && scene.placements.size() > scene.entries;
  const TreeRegion region = region_in(tree, placement, box);
  Next last = Next::kOn;
  walk_tree(
      tree, region,
      [&](std::uint32_t leaf) {
        last = decide_leaf(box, placement, tree, leaf, found, left);
        return last == Next::kOn || (last == Next::kNextPlacement && shares_tree);
      },
      [&] {
        ++counts_.nodes;
        return !out_of_time();
      });
  return last != Next::kStop && !stopped_;
}

/// `left(instance)`: nothing more of that one is wanted.
template <class Box, class Found, class Left>
void BoxOverlaps::walk(const Box& box, Found found, Left left) {
  const SceneTree& tree = scene_.tree();
  if (tree.entries == 1) {
    walk_placement(box, tree.placements[0], found, left);
    return;
  }
  walk_tree(
      tree.top, world_region(tree.top, box),
      [&](std::uint32_t leaf) {
        const LeafBlock& block = tree.top.blocks(leaf).front();
        for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
          if (!walk_placement(box, tree.placements[block.triangle(lane)], found, left))
            return false;
        }
        return true;
      },
      [&] {
        ++counts_.nodes;
        return !out_of_time();
      });
}

bool BoxOverlaps::any(const BoxBatch& boxes, std::size_t i, BoxRelation relation) {
  bool touched = false;
  relation_ = relation;
  boxes.visit(i, [&](const auto& box) {
    if (!has_time_for(box)) return;
    walk(
        prepared(box),
        [&](TriangleId) {
          touched = true;
          return Next::kStop;
        },
        kNoneLeft);
  });
  return touched;
}

void BoxOverlaps::keep_smallest(std::size_t limit) {
  if (triangles_.size() <= limit) return;
  std::nth_element(triangles_.begin(), triangles_.begin() + static_cast<std::ptrdiff_t>(limit),
                   triangles_.end());
  triangles_.resize(limit);
}

/// Leaves the first `limit` of the ids, of `resolved` that there were from the asked place on.
template <class Id>
void BoxOverlaps::cut(std::vector<Id>& ids, std::uint64_t resolved, std::size_t limit) {
  std::sort(ids.begin(), ids.end());
  if (ids.size() > limit) ids.resize(limit);
  next_ = resolved > ids.size() && !ids.empty() ? list_place(ids.back()) + 1 : 0;
}

template <class Box>
std::uint64_t BoxOverlaps::list_triangles(const Box& box, std::size_t limit, std::uint64_t from) {
  // Twice the limit, then cut: memory stays in proportion to what is asked for.
  const std::size_t room = limit < (std::size_t{1} << 60) ? std::max<std::size_t>(2 * limit, 4096)
                                                          : static_cast<std::size_t>(-1);
  std::uint64_t total = 0, resolved = 0;
  walk(
      box,
      [&](TriangleId id) {
        ++total;
        if (list_place(id) < from) return Next::kOn;
        ++resolved;
        if (limit > 0) {
          triangles_.push_back(id);
          if (triangles_.size() >= room) keep_smallest(limit);
        }
        return Next::kOn;
      },
      kNoneLeft);
  keep_smallest(limit);
  cut(triangles_, resolved, limit);
  return total;
}

/// Takes those out of nodes_ that have a triangle beyond the box.
template <class Box>
void BoxOverlaps::leave_nodes_within(const Box& box) {
  if (nodes_.empty()) return;
  const SceneDescription& description = scene_.description();
  for (std::uint32_t i = 0; i < description.instances.size() && !stopped_; ++i) {
    const Instance& instance = description.instances[i];
    const std::uint32_t triangles = description.meshes[instance.mesh]->triangle_count();
    for (std::uint32_t t = 0; t < triangles && node_seen_[instance.node] == query_; ++t) {
      if (out_of_time()) return;
      const Triangle triangle = scene_.world_triangle({i, t});
      if (corners_within(triangle, box)) continue;
      if (is_finite(triangle) && !is_degenerate(triangle)) node_seen_[instance.node] = 0;
    }
  }
  std::erase_if(nodes_, [&](std::uint32_t node) { return node_seen_[node] != query_; });
}

template <class Box>
std::uint64_t BoxOverlaps::list_nodes(const Box& box, std::size_t limit, std::uint64_t from) {
  if (++query_ == 0) {
    std::fill(node_seen_.begin(), node_seen_.end(), 0);
    query_ = 1;
  }
  const auto node_of = [&](std::uint32_t instance) {
    return scene_.description().instances[instance].node;
  };
  walk(
      box,
      [&](TriangleId id) {
        node_seen_[node_of(id.instance)] = query_;
        nodes_.push_back(node_of(id.instance));
        return Next::kNextPlacement;
      },
      [&](std::uint32_t instance) { return node_seen_[node_of(instance)] == query_; });
  if (relation_ == BoxRelation::kContained) leave_nodes_within(box);
  const std::uint64_t total = nodes_.size();
  std::erase_if(nodes_, [&](std::uint32_t node) { return list_place(node) < from; });
  cut(nodes_, nodes_.size(), limit);
  return total;
}

std::uint64_t BoxOverlaps::list(const BoxBatch& boxes, std::size_t i, BoxTargets targets,
                                std::size_t limit, BoxRelation relation, std::uint64_t from) {
  triangles_.clear();
  nodes_.clear();
  relation_ = relation;
  return boxes.visit(i, [&](const auto& box) {
    if (!has_time_for(box)) return std::uint64_t{0};
    const auto& shape = prepared(box);
    return targets == BoxTargets::kTriangles ? list_triangles(shape, limit, from)
                                             : list_nodes(shape, limit, from);
  });
}

}  // namespace sightline
