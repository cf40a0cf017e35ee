#include "core/trace/inspect/tree_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/trace/leaf_triangle.h"

namespace sightline {

namespace {

Box3d child_box(const WideNode& node, std::size_t i) {
  Box3d box;
  for (int k = 0; k < 3; ++k) {
    box.min[k] = static_cast<double>(node.lower[k][i]);
    box.max[k] = static_cast<double>(node.upper[k][i]);
  }
  return box;
}

bool contains(const Box3d& outer, const Vec3d& p) {
  for (int k = 0; k < 3; ++k)
    if (p[k] < outer.min[k] || p[k] > outer.max[k]) return false;
  return true;
}

/// Half of it; of an empty box 0.
double area(const Box3d& box) {
  if (box.empty()) return 0;
  const double x = box.max.x - box.min.x, y = box.max.y - box.min.y, z = box.max.z - box.min.z;
  return x * y + y * z + z * x;
}

double shared_area(const Box3d& a, const Box3d& b) {
  Box3d both;
  for (int k = 0; k < 3; ++k) {
    both.min[k] = std::max(a.min[k], b.min[k]);
    both.max[k] = std::min(a.max[k], b.max[k]);
  }
  return area(both);
}

struct Sums {
  double children = 0, leaf_depths = 0, node_areas = 0, overlaps = 0, pairs = 0, root_area = 0;
};

struct ReportNode {
  std::uint32_t ref;
  std::uint32_t depth;
  Box3d box;
};

/// leaf(ref, box) counts what stands in a leaf and says whether it lies inside.
template <class Leaf>
TreeReport report(const WideTree& tree, Leaf leaf) {
  TreeReport report;
  if (tree.root == ChildRef::kEmpty) return report;
  Sums sums;
  report.shallowest = std::numeric_limits<std::uint32_t>::max();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  std::vector<ReportNode> waiting{{tree.root, 1, {{-kInf, -kInf, -kInf}, {kInf, kInf, kInf}}}};
  while (!waiting.empty()) {
    const ReportNode place = waiting.back();
    waiting.pop_back();
    if (ChildRef::is_leaf(place.ref)) {
      ++report.leaves;
      const std::uint32_t blocks = ChildRef::blocks(place.ref);
      report.blocks += blocks;
      if (place.depth > 1) sums.node_areas += area(place.box) * blocks;
      sums.leaf_depths += place.depth - 1;
      report.shallowest = std::min(report.shallowest, place.depth - 1);
      report.contained = leaf(place.ref, place.box, report.triangles) && report.contained;
      continue;
    }
    ++report.nodes;
    report.depth = std::max(report.depth, place.depth);
    const WideNode& node = tree.node(place.ref);
    Box3d own;
    for (std::size_t i = 0; i < kArity; ++i) {
      if (node.child[i] == ChildRef::kEmpty) continue;
      const Box3d box = child_box(node, i);
      own.include(box);
      ++sums.children;
      report.contained =
          report.contained && contains(place.box, box.min) && contains(place.box, box.max);
      for (std::size_t j = 0; j < i; ++j) {
        if (node.child[j] == ChildRef::kEmpty) continue;
        const Box3d other = child_box(node, j);
        const double both = area(box) + area(other);
        if (both > 0) sums.overlaps += 2 * shared_area(box, other) / both;
        ++sums.pairs;
      }
      waiting.push_back({node.child[i], place.depth + 1, box});
    }
    if (place.depth == 1) sums.root_area = area(own);
    sums.node_areas += area(place.depth == 1 ? own : place.box);
  }
  report.mean_depth = sums.leaf_depths / static_cast<double>(report.leaves);
  if (report.nodes > 0) report.arity = sums.children / static_cast<double>(report.nodes);
  if (sums.root_area > 0) report.sah_cost = sums.node_areas / sums.root_area;
  if (sums.pairs > 0) report.overlap = sums.overlaps / sums.pairs;
  return report;
}

}  // namespace

TreeReport report_tree(const SceneView& scene, std::uint32_t entry) {
  const SceneTree& trees = scene.tree();
  const Placement& entered = trees.placements[entry];
  const WideTree& tree = *trees.trees[entered.tree];
  const double scale = std::ldexp(1.0, tree.scale_exponent);
  return report(tree, [&](std::uint32_t ref, const Box3d& box, std::uint64_t& triangles) {
    bool inside = true;
    for (const LeafBlock& block : tree.blocks(ref)) {
      const Placement& placement = (&entered)[block.placement()];
      // A tree of the mesh's own space has the mesh's corners.
      const Placement here = entered.world_boxes ? placement : Placement{};
      for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
        ++triangles;
        const Triangle t = world_triangle(here, block, lane);
        for (const Vec3d* v : {&t.v0, &t.v1, &t.v2}) {
          inside = inside && contains(box, {v->x * scale, v->y * scale, v->z * scale});
        }
      }
    }
    return inside;
  });
}

TreeReport report_top_tree(const SceneView& scene) {
  const WideTree& top = scene.tree().top;
  return report(top, [&](std::uint32_t ref, const Box3d&, std::uint64_t& entries) {
    for (const LeafBlock& block : top.blocks(ref)) entries += block.lane_count();
    return true;
  });
}

}  // namespace sightline
