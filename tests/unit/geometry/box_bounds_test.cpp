/// Derives the constants of core/geometry/box_bounds.h again, in rational numbers, from the
/// sentences of docs/explanation/exactness-boxes.md.

#include "core/geometry/box_bounds.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

namespace sightline::box_bounds {
namespace {

const mpq_class u(0x1p-53);
const mpq_class tiny(0x1p-1074);

TEST(BoxBounds, a_rounded_difference_divided_is_within_two_u) {
  // |t - T| <= u (|T| (1 + u) + tiny/2) + u |T| + tiny/2, twice, and a gap rounded once.
  const mpq_class relative = u * (1 + u) + u;
  const mpq_class floor = u * tiny / 2 + tiny / 2;
  EXPECT_GE(mpq_class(kCrossingSlack) * (1 - 4 * u) / (1 + u), relative);
  EXPECT_GE((mpq_class(kCrossingFloor) * (1 - 2 * u) - 2 * tiny) / (1 + u), 2 * floor);
  // The second last T is at most |T| + gap in magnitude: both errors are below the gap.
  const mpq_class second = mpq_class(kSecondSlack) * (1 - relative) / (1 + u);
  EXPECT_GE(second * mpq_class(kCrossingSlack) * (1 - 4 * u), 2 * relative);
  EXPECT_GE(second * (mpq_class(kCrossingFloor) * (1 - 2 * u) - 2 * tiny), 2 * floor);
}

TEST(BoxBounds, four_products_lose_eight_u_squared) {
  // Rests up to u S, products with low parts up to u S: their roundings, and three sums of them.
  const mpq_class rests = u * (2 * u) + u * (2 * u) + u * (2 * u + 2 * u) * (1 + u);
  EXPECT_GE(mpq_class(kProductsSlack) * (1 - 4 * u), rests);
  // The gap's own rounding and that of the last sum.
  EXPECT_GE(mpq_class(kGapSlack) * (1 - 4 * u), 2 * u + u * u);
  EXPECT_GE(mpq_class(kProductsSlack) * mpq_class(0x1p-900), 16 * tiny) << "S > 2^-900";
}

TEST(BoxBounds, one_step_of_division_leaves_less_than_eight_u_of_the_correction) {
  const mpq_class lost = 2 * u + u * u;
  // s has to cover what was lost, and the rounding of e +- s with |e| <= |c|.
  const mpq_class s = mpq_class(kRefineSlack) * (1 - u);
  EXPECT_GE(s - u * (1 + s), lost);
  EXPECT_GE(mpq_class(kRefineFloor) * (1 - u), tiny);
}

TEST(BoxBounds, products_of_batches_neither_underflow_nor_overflow) {
  EXPECT_GE(mpq_class(kProductLeast) * mpq_class(0x1p-106), tiny);
  const mpq_class largest(0x1.fffffffffffffp1023);
  EXPECT_LT(mpq_class(kProductMost) * mpq_class(0x1p27 + 1), largest) << "Dekker's splitting";
  EXPECT_LT(mpq_class(kProductMost) * 8 * 2, largest) << "the sum of eight terms";
}

TEST(BoxBounds, a_compensated_sum_of_seven_terms_and_six_products_keeps_98_bits) {
  const mpq_class errors = 7 * u * (1 + 7 * u) + u;        // of TwoSums and TwoProducts, times M
  const mpq_class plain = 12 * u * errors * (1 + 13 * u);  // adding thirteen of them up
  // M itself is computed with seven roundings, the bound with one more.
  EXPECT_GE(mpq_class(kSumSlack) * (1 - 8 * u), plain);
  EXPECT_GE(mpq_class(kSumFloor), 2 * tiny / 2);
}

TEST(BoxBounds, a_quotient_of_two_such_sums_keeps_100_bits) {
  const mpq_class c = u + u + u + 3 * u * u;  // |c| in units of |T|
  const mpq_class roundings = u * u + u * (2 * u) * (1 + u) + u * c + u * c;
  const mpq_class rate = mpq_class(kRateError);
  const mpq_class spread = 1 / (1 - rate - u);  // r against rh
  const mpq_class own = roundings + spread * (u * c);
  EXPECT_GE(mpq_class(kQuotientSlack) * (1 - 4 * u), own);
  // The rest goes with the errors of n and r: their own part, and er / rh times |c|.
  EXPECT_GE(mpq_class(kQuotientFactor) * (1 - 8 * u), spread * (1 + c));
  EXPECT_GE(mpq_class(kQuotientFloor), 64 * tiny);
}

TEST(BoxBounds, a_placed_corner_loses_four_u) {
  const mpq_class roundings = (1 + u) * (1 + u) * (1 + u) * (1 + u) - 1;
  EXPECT_GE(mpq_class(kPlacedSlack) * (1 - 5 * u), roundings / (1 - 4 * u));
  EXPECT_GE(mpq_class(kPlacedFloor), 3 * tiny);
}

/// In units of D_i D_j, with deltas as a fraction of the extents: what a difference of two products
/// of coordinates' differences loses.
mpq_class cross_loss(const mpq_class& delta_first, const mpq_class& delta_second) {
  // x = e_i q_j - e_j q_i; e known up to delta_first + u, q up to delta_second + u, both at most 1.
  const mpq_class each =
      (delta_first + u) + (delta_second + u) + (delta_first + u) * (delta_second + u);
  return 2 * each + 2 * u * (1 + each) + u * (2 + 2 * each) * (1 + u);
}

TEST(BoxBounds, cross_products_stay_within_their_bound) {
  EXPECT_GE(mpq_class(kCrossSlack) * (1 - 8 * u), cross_loss(0, 0));
  // With delta = x D on both axes the bound is kCrossDelta * 2 x. The worse of both kinds is the
  // third corner, where both factors are differences. Extents are at least four deltas: x <= 1/4.
  for (const mpq_class& x :
       {mpq_class(1, 4), mpq_class(1, 8), mpq_class(0x1p-10), mpq_class(0x1p-40)}) {
    EXPECT_GE(mpq_class(kCrossDelta) * 2 * x + mpq_class(kCrossSlack), cross_loss(2 * x, 2 * x))
        << x;
  }
}

TEST(BoxBounds, normals_stay_within_their_bound) {
  // In units of P = D_x D_y D_z: three terms n_k q_k, |n_k| <= 2, |q_k| <= 1.
  const auto loss = [](const mpq_class& delta) {
    const mpq_class cross = cross_loss(2 * delta, 2 * delta);
    const mpq_class product = (2 + cross) * (1 + delta + u) - 2;
    const mpq_class rounded = product + u * (2 + product);
    return mpq_class(3 * rounded + 2 * u * (6 + 3 * rounded) * (1 + u));
  };
  const auto bound = [](const mpq_class& delta) {
    const mpq_class cross = mpq_class(kCrossDelta) * 2 * delta + mpq_class(kCrossSlack);
    return mpq_class(3 * cross + 3 * mpq_class(kNormalDelta) * delta + mpq_class(kNormalSlack));
  };
  EXPECT_GE(bound(0) * (1 - 8 * u), loss(0));
  for (const mpq_class& x :
       {mpq_class(1, 6), mpq_class(1, 16), mpq_class(0x1p-10), mpq_class(0x1p-40)}) {
    EXPECT_GE(bound(x), loss(x)) << x;
  }
  EXPECT_GE(bound(mpq_class(1, 6)), mpq_class(61, 10)) << "beyond, no range of 6 P can decide";
}

}  // namespace
}  // namespace sightline::box_bounds
