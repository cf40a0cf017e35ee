#pragma once
/// The exact surface-area heuristic for a handful of boxes: every cut of every sorted axis.

#include <array>
#include <cstddef>

#include "core/bvh/histogram.h"

namespace sightline {

/// Sorts a few boxes by the axis of the cheapest cut and returns that cut. Twice the speed of bins
/// for so few, and a better tree.
class Sweep {
 public:
  static constexpr std::uint32_t kMax = 8;

  /// Precondition: 2 <= count <= kMax.
  static Split cut(BuildBox* boxes, std::uint32_t count, BlockSize size) {
    std::array<std::array<std::uint32_t, kMax>, 3> order;
    Split best;
    alignas(16) float middle[kMax][4];
    for (std::uint32_t i = 0; i < count; ++i) boxes[i].middle().store(middle[i]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      auto& sorted = order[axis];
      for (std::uint32_t i = 0; i < count; ++i) {
        std::uint32_t k = i;
        for (; k > 0 && middle[i][axis] < middle[sorted[k - 1]][axis]; --k)
          sorted[k] = sorted[k - 1];
        sorted[k] = i;
      }
      std::array<float, kMax> right_cost;
      Bounds right;
      for (std::uint32_t i = count - 1; i > 0; --i) {
        right.include(boxes[sorted[i]]);
        right_cost[i] = size.blocks(count - i) * right.half_area();
      }
      Bounds left;
      for (std::uint32_t i = 1; i < count; ++i) {
        left.include(boxes[sorted[i - 1]]);
        const float cost = size.blocks(i) * left.half_area() + right_cost[i];
        if (cost < best.cost) best = {cost, axis, i};
      }
    }
    std::array<BuildBox, kMax> sorted;
    for (std::uint32_t i = 0; i < count; ++i) sorted[i] = boxes[order[best.axis][i]];
    for (std::uint32_t i = 0; i < count; ++i) boxes[i] = sorted[i];
    return best;
  }
};

}  // namespace sightline
