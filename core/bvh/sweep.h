#pragma once
/// Exact surface-area heuristic for a few boxes: tries every cut on every axis. (It sweeps over
/// sorted boxes; the sweeps of core/geometry are something else.)

#include <array>
#include <cstddef>
#include <utility>

#include "core/bvh/histogram.h"

namespace sightline {

/// Finds the cheapest cut of a few boxes. For so few it takes half the time of bins and gives a
/// better tree.
class Sweep {
 public:
  /// The most boxes that cut() accepts.
  static constexpr std::uint32_t kMax = 8;

  /// Sorts the boxes by their centroids on the axis of the cheapest cut, and returns that cut: the
  /// first Split::place boxes go left. Precondition: 2 <= count <= kMax.
  static Split cut(BuildBox* boxes, std::uint32_t count, BlockSize size) {
    if (count == 2) return cut_pair(boxes, size);
    Order order;
    // On all axes at once and without branches: which centroid is smaller cannot be predicted.
    std::array<Float4, kMax> middle;
    std::array<Int4, kMax> rank{};
    for (std::uint32_t i = 0; i < count; ++i) {
      middle[i] = boxes[i].middle();
      for (std::uint32_t j = 0; j < i; ++j) {
        const Mask4 before = less_or_equal(middle[j], middle[i]);
        rank[i].v -= before.v;
        rank[j].v += before.v + 1;
      }
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        order[axis][static_cast<std::uint32_t>(rank[i][axis])] = i;
    }
    std::array<Float4, kMax> right_cost;
    Side right;
    for (std::uint32_t i = count - 1; i > 0; --i) {
      right.include(boxes, order, i);
      right_cost[i] = size.blocks(right.triangles) * right.bounds.half_areas();
    }
    CheapestPerAxis cheapest;
    Side left;
    for (std::uint32_t i = 1; i < count; ++i) {
      left.include(boxes, order, i - 1);
      cheapest.consider(size.blocks(left.triangles) * left.bounds.half_areas() + right_cost[i],
                        static_cast<int>(i));
    }
    const Split best = cheapest.of_all_axes();
    std::array<BuildBox, kMax> sorted;
    for (std::uint32_t i = 0; i < count; ++i) sorted[i] = boxes[order[best.axis][i]];
    for (std::uint32_t i = 0; i < count; ++i) boxes[i] = sorted[i];
    return best;
  }

 private:
  /// The numbers of the boxes along each axis.
  using Order = std::array<std::array<std::uint32_t, kMax>, 3>;
  /// All boxes on one side of a cut, for each axis.
  struct Side {
    BoundsPerAxis bounds;
    Int4 triangles{};

    /// Adds the box with index i in the order of each axis.
    void include(const BuildBox* boxes, const Order& order, std::uint32_t i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const BuildBox& box = boxes[order[axis][i]];
        bounds.axis[axis].include(box);
        triangles.v[axis] += static_cast<int>(box.count);
      }
    }
  };

  /// The cut of two boxes costs the same on every axis, so the first axis is chosen. Up to half
  /// of the cuts of a tree over single boxes are of two.
  static Split cut_pair(BuildBox* boxes, BlockSize size) {
    alignas(16) float middle[2][4];
    for (std::size_t i = 0; i < 2; ++i) boxes[i].middle().store(middle[i]);
    if (middle[1][0] < middle[0][0]) std::swap(boxes[0], boxes[1]);
    Split split;
    Bounds left, right;
    left.include(boxes[0]);
    right.include(boxes[1]);
    const Float4 blocks = size.blocks(
        Int4{{static_cast<int>(boxes[0].count), static_cast<int>(boxes[1].count), 0, 0}});
    const float cost = blocks.v[0] * left.half_area() + blocks.v[1] * right.half_area();
    if (cost < split.cost) split = {cost, 0, 1};
    return split;
  }
};

}  // namespace sightline
