#include "core/bvh/top_tree.h"

#include <array>
#include <cmath>

#include "core/bvh/collapse.h"
#include "core/bvh/reinsert.h"
#include "core/bvh/triangle_tree.h"
#include "core/geometry/rounding.h"

namespace sightline {

WideTree build_top(std::span<const Box3d> bounds, const Box3d& all, TreeQuality quality,
                   const CancelFlag* cancel) {
  const int scale_exponent = choose_scale_exponent(all);
  const double scale = std::ldexp(1.0, scale_exponent);
  Column<BuildBox> boxes(bounds.size());
  for (std::uint32_t i = 0; i < bounds.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      boxes[i].lower[k] = float_below(bounds[i].min[k] * scale);
      boxes[i].upper[k] = float_above(bounds[i].max[k] * scale);
    }
    boxes[i].id = i;
    boxes[i].count = 1;
  }
  // Entering a placement is slow: leaves of one.
  BinaryOptions options;
  options.block_size = {0};
  options.leaf_max = 1;
  options.cancel = cancel;
  CollapseOptions costs;
  costs.block = 1;
  costs.leaf_max = 1;
  costs.cancel = cancel;
  BinaryTree binary = build_binary_tree(std::move(boxes), options);
  if (quality == TreeQuality::kHigh) reinsert(binary, {.cancel = cancel});
  WideTree top =
      collapse(binary, costs,
               {.size =
                    [](std::uint32_t, std::uint32_t) {
                      return LeafSize{1, 1};
                    },
                .write =
                    [&](std::uint32_t first, std::uint32_t, LeafBlock* block) {
                      const std::uint32_t placement = binary.ids[first];
                      block->set_names({placement, placement, placement, placement}, 1, 0);
                      return block->next();
                    }});
  top.scale_exponent = scale_exponent;
  top.bounds = all;
  return top;
}

}  // namespace sightline
