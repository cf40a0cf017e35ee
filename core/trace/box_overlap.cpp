#include "core/trace/box_overlap.h"

#include <algorithm>
#include <array>

#include "core/geometry/triangle_box.h"
#include "core/trace/box_region.h"

namespace sightline {

namespace {

/// What the finder of a triangle wants next.
enum class Next {
  kOn,             ///< the next triangle
  kNextPlacement,  ///< nothing more of this placement
  kStop,
};

/// Nodes between two looks at the clock: some microseconds.
constexpr std::uint64_t kNodesPerLook = 64;

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

/// A lane of a leaf block as the world sees it: the same arithmetic as Scene::world_triangle.
Triangle world_triangle(const Placement& placement, const LeafBlock& block, std::size_t lane) {
  const auto corner = [&](std::size_t c) {
    const Vec3f p{block.corner[c][0][lane], block.corner[c][1][lane], block.corner[c][2][lane]};
    return placement.world_from_mesh.apply(p);
  };
  return {corner(0), corner(1), corner(2)};
}

}  // namespace

bool BoxOverlaps::out_of_time() {
  if (++looks_ % kNodesPerLook == 0 && deadline_.passed()) stopped_ = true;
  return stopped_;
}

template <class Box, class Found>
bool BoxOverlaps::decide_leaf(const Box& box, const Placement& placement, const WideTree& tree,
                              std::uint32_t leaf, Found& found) {
  const LeafBlock* blocks = tree.blocks(leaf);
  for (std::uint32_t b = 0; b < ChildRef::blocks(leaf); ++b) {
    for (std::uint32_t lane = 0; lane < blocks[b].lane_count; ++lane) {
      ++counts_.triangles;
      if (!triangle_meets_box(world_triangle(placement, blocks[b], lane), box)) continue;
      if (found(TriangleId{placement.instance, blocks[b].triangle[lane]}) != Next::kOn)
        return false;
    }
  }
  return true;
}

/// Returns false to end the whole walk. A placement that is left early ends only its own.
template <class Box, class Found>
bool BoxOverlaps::walk_placement(const Box& box, const Placement& placement, Found& found) {
  const WideTree& tree = *scene_.tree().trees[placement.tree];
  const TreeRegion region =
      placement.world_boxes ? world_region(tree, box) : mapped_region(tree, placement.space, box);
  Next last = Next::kOn;
  const auto remember = [&](TriangleId id) { return last = found(id); };
  walk_tree(
      tree, region,
      [&](std::uint32_t leaf) { return decide_leaf(box, placement, tree, leaf, remember); },
      [&] {
        ++counts_.nodes;
        return !out_of_time();
      });
  return last != Next::kStop && !stopped_;
}

template <class Box, class Found>
void BoxOverlaps::walk(const Box& box, Found found) {
  const SceneTree& tree = scene_.tree();
  if (tree.placements.size() == 1) {
    walk_placement(box, tree.placements[0], found);
    return;
  }
  walk_tree(
      tree.top, world_region(tree.top, box),
      [&](std::uint32_t leaf) {
        const LeafBlock& block = *tree.top.blocks(leaf);
        for (std::uint32_t lane = 0; lane < block.lane_count; ++lane) {
          if (!walk_placement(box, tree.placements[block.triangle[lane]], found)) return false;
        }
        return true;
      },
      [&] {
        ++counts_.nodes;
        return !out_of_time();
      });
}

bool BoxOverlaps::any(const BoxBatch& boxes, std::size_t i) {
  bool touched = false;
  boxes.visit(i, [&](const auto& box) {
    walk(box, [&](TriangleId) {
      touched = true;
      return Next::kStop;
    });
  });
  return touched;
}

void BoxOverlaps::keep_smallest(std::size_t limit) {
  if (triangles_.size() <= limit) return;
  std::nth_element(triangles_.begin(), triangles_.begin() + static_cast<std::ptrdiff_t>(limit),
                   triangles_.end());
  triangles_.resize(limit);
}

std::uint64_t BoxOverlaps::list(const BoxBatch& boxes, std::size_t i, BoxTargets targets,
                                std::size_t limit) {
  triangles_.clear();
  nodes_.clear();
  std::uint64_t total = 0;
  if (targets == BoxTargets::kTriangles) {
    // Twice the limit, then cut: memory stays in proportion to what is asked for.
    const std::size_t room = limit < (std::size_t{1} << 60) ? std::max<std::size_t>(2 * limit, 4096)
                                                            : static_cast<std::size_t>(-1);
    boxes.visit(i, [&](const auto& box) {
      walk(box, [&](TriangleId id) {
        ++total;
        if (limit > 0) {
          triangles_.push_back(id);
          if (triangles_.size() >= room) keep_smallest(limit);
        }
        return Next::kOn;
      });
    });
    keep_smallest(limit);
    std::sort(triangles_.begin(), triangles_.end());
    return total;
  }

  if (++query_ == 0) {
    std::fill(node_seen_.begin(), node_seen_.end(), 0);
    query_ = 1;
  }
  boxes.visit(i, [&](const auto& box) {
    walk(box, [&](TriangleId id) {
      const std::uint32_t node = scene_.description().instances[id.instance].node;
      if (node_seen_[node] != query_) {
        node_seen_[node] = query_;
        nodes_.push_back(node);
      }
      return Next::kNextPlacement;
    });
  });
  total = nodes_.size();
  std::sort(nodes_.begin(), nodes_.end());
  if (nodes_.size() > limit) nodes_.resize(limit);
  return total;
}

}  // namespace sightline
