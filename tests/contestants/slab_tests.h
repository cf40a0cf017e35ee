#pragma once
/// Ray-box tests as texts and papers give them, right and wrong, for golden cases and benchmarks.
/// Each is written the way its source writes it, in float64; none is mended.

#include <span>
#include <string_view>

#include "core/geometry/box3.h"
#include "core/query/ray_batch.h"

namespace sightline::contestants {

struct SlabAnswer {
  bool hit = false;
  double t = 0;      ///< what the text calls the answer; unspecified for a miss
  double enter = 0;  ///< of the line; not every text computes both
  double exit = 0;
};

struct SlabTest {
  std::string_view name;
  std::string_view about;
  SlabAnswer (*test)(const Ray& ray, const Box3d& box);
};

/// In order: slab_swap_divide, williams2005, branchless_min_max, fma_inverse, ize2013_padded, then
/// those with a known mistake: inverted_parallel, slide_iteration_2, d_ge_0, tgmin_positive,
/// entry_returned, pairwise_2d (x and y only), example_code_3d.
std::span<const SlabTest> slab_tests();
/// Precondition: the name is one of the list.
const SlabTest& slab_test(std::string_view name);

}  // namespace sightline::contestants
