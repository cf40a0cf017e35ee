#include "core/bvh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/bvh/collapse.h"
#include "core/bvh/tree_corners.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

void write_block(const MeshView& mesh, std::span<const BuildBox> boxes, LeafBlock& block) {
  double edge_max = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t triangle = boxes[lane < boxes.size() ? lane : 0].id;
    const std::uint32_t* index = &mesh.indices[std::size_t{triangle} * 3];
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3f& p = mesh.positions[index[corner]];
      const Vec3f& q = mesh.positions[index[corner == 2 ? 0 : corner + 1]];
      for (int axis = 0; axis < 3; ++axis) {
        block.corner[corner][axis][lane] = p[axis];
        // A difference of two float32 is off by at most half a float64 ulp: float_above covers it.
        edge_max = std::max(edge_max,
                            std::abs(static_cast<double>(q[axis]) - static_cast<double>(p[axis])));
      }
    }
    block.triangle[lane] = triangle;
  }
  block.edge_max = float_above(next_above(edge_max));
  block.lane_count = static_cast<std::uint32_t>(boxes.size());
}

}  // namespace

int choose_scale_exponent(const Box3d& bounds) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    largest = std::max({largest, std::abs(bounds.min[k]), std::abs(bounds.max[k])});
  }
  if (!(largest > 0)) return 0;
  // Capped so that the power itself is a finite float64.
  const int exponent = std::clamp(std::ilogb(largest), -1000, 1023);
  return exponent > 40 || exponent < -40 ? -exponent : 0;
}

WideTree build_triangle_tree(const MeshView& mesh, const Affine* world_from_mesh) {
  const std::uint32_t count = mesh.triangle_count();
  Column<BuildBox> boxes(count);
  Box3d bounds;
  std::uint32_t used = 0;
  // Bounds first: they choose the units of the boxes.
  for (std::uint32_t i = 0; i < count; ++i) {
    const TreeCorners corners = tree_corners(mesh, i, world_from_mesh);
    if (!corners.usable) continue;
    boxes[used++].id = i;
    for (const Vec3d& p : corners.at) bounds.include(p);
  }
  boxes.resize(used);
  const int scale_exponent = used == 0 ? 0 : choose_scale_exponent(bounds);
  const double scale = std::ldexp(1.0, scale_exponent);

  parallel_for((used + 4095) / 4096, [&](std::size_t index) {
    const auto chunk = static_cast<std::uint32_t>(index);
    for (std::uint32_t i = chunk * 4096; i < std::min(used, (chunk + 1) * 4096); ++i) {
      const TreeCorners corners = tree_corners(mesh, boxes[i].id, world_from_mesh);
      for (int k = 0; k < 3; ++k) {
        const double a = corners.at[0][k] * scale;
        const double b = corners.at[1][k] * scale;
        const double c = corners.at[2][k] * scale;
        boxes[i].lower[k] = float_below(std::min({a, b, c}));
        boxes[i].upper[k] = float_above(std::max({a, b, c}));
      }
      boxes[i].padding = 0;
    }
  });

  const BinaryTree binary = build_binary_tree(boxes, {});
  WideTree tree = collapse(binary, [&](std::uint32_t first, std::uint32_t leaf_count,
                                       LeafBlock* blocks) {
    const std::span<const BuildBox> leaf(&boxes[first], leaf_count);
    for (std::size_t i = 0; i < leaf.size(); i += kLanes) {
      write_block(mesh, leaf.subspan(i, std::min<std::size_t>(kLanes, leaf.size() - i)), *blocks++);
    }
  });
  tree.scale_exponent = scale_exponent;
  tree.bounds = bounds;
  return tree;
}

}  // namespace sightline
