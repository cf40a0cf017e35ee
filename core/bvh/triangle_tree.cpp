#include "core/bvh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/bvh/collapse.h"
#include "core/bvh/reinsert.h"
#include "core/bvh/tree_corners.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

void write_block(const MeshView& mesh, std::span<const std::uint32_t> ids, LeafBlock& block) {
  double edge_max = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t triangle = ids[lane < ids.size() ? lane : 0];
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
  block.lane_count = static_cast<std::uint32_t>(ids.size());
}

/// The boxes of a mesh's usable triangles, in tree units.
struct BuildBoxes {
  Column<BuildBox> boxes;
  Box3d bounds;  ///< of the triangles, before units
  int scale_exponent = 0;

  BuildBoxes(const MeshView& mesh, const Affine* world_from_mesh)
      : boxes(mesh.triangle_count()), mesh_(mesh), world_from_mesh_(world_from_mesh) {
    make();
    scale_exponent = bounds.empty() ? 0 : choose_scale_exponent(bounds);
    // Rare: the bounds turn out to ask for other units.
    if (scale_exponent != 0) make();
  }

 private:
  static constexpr std::uint32_t kChunk = 4096;

  /// Each chunk packs its own boxes; chunks move together only if one of them has gaps.
  void make() {
    const std::uint32_t count = mesh_.triangle_count();
    boxes.resize(count);
    const std::uint32_t chunks = (count + kChunk - 1) / kChunk;
    std::vector<std::uint32_t> used(chunks);
    std::vector<Box3d> within(chunks);
    parallel_for(chunks, [&](std::size_t chunk) {
      const auto first = static_cast<std::uint32_t>(chunk) * kChunk;
      used[chunk] = make_chunk(first, std::min(count, first + kChunk), within[chunk]);
    });
    bounds = {};
    BuildBox* end = boxes.data();
    for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
      bounds.include(within[chunk]);
      const BuildBox* from = boxes.data() + std::size_t{chunk} * kChunk;
      end = end == from ? end + used[chunk] : std::copy(from, from + used[chunk], end);
    }
    boxes.resize(static_cast<std::size_t>(end - boxes.data()));
  }

  std::uint32_t make_chunk(std::uint32_t first, std::uint32_t end, Box3d& within) {
    const double scale = std::ldexp(1.0, scale_exponent);
    BuildBox* to = &boxes[first];
    for (std::uint32_t i = first; i < end; ++i) {
      const TreeCorners corners = tree_corners(mesh_, i, world_from_mesh_);
      if (!corners.usable) continue;
      for (const Vec3d& p : corners.at) within.include(p);
      for (int k = 0; k < 3; ++k) {
        const double a = corners.at[0][k] * scale;
        const double b = corners.at[1][k] * scale;
        const double c = corners.at[2][k] * scale;
        to->lower[k] = float_below(std::min({a, b, c}));
        to->upper[k] = float_above(std::max({a, b, c}));
      }
      to->id = i;
      to->padding = 0;
      ++to;
    }
    return static_cast<std::uint32_t>(to - &boxes[first]);
  }

  const MeshView& mesh_;
  const Affine* world_from_mesh_;
};

}  // namespace

int choose_scale_exponent(const Box3d& bounds) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    largest = std::max({largest, std::abs(bounds.min[k]), std::abs(bounds.max[k])});
  }
  if (!(largest > 0)) return 0;
  // Capped so that the power itself is a finite float64.
  const int exponent = std::clamp(std::ilogb(largest), -1000, 1022);
  return exponent > 40 || exponent < -40 ? -exponent : 0;
}

WideTree build_triangle_tree(const MeshView& mesh, const Affine* world_from_mesh,
                             TreeQuality quality) {
  BuildBoxes made(mesh, world_from_mesh);
  const Box3d bounds = made.bounds;
  const int scale_exponent = made.scale_exponent;
  BinaryTree binary = build_binary_tree(std::move(made.boxes), {});
  if (quality == TreeQuality::kHigh) reinsert(binary, {});
  WideTree tree =
      collapse(binary, {}, [&](std::uint32_t first, std::uint32_t count, LeafBlock* blocks) {
        const std::span<const std::uint32_t> leaf(&binary.ids[first], count);
        for (std::size_t i = 0; i < leaf.size(); i += kLanes) {
          write_block(mesh, leaf.subspan(i, std::min<std::size_t>(kLanes, leaf.size() - i)),
                      *blocks++);
        }
      });
  tree.scale_exponent = scale_exponent;
  tree.bounds = bounds;
  return tree;
}

}  // namespace sightline
