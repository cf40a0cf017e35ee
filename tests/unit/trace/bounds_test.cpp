// Derives from the formulas of docs/explanation/exactness.md the smallest constants that its proofs allow, in
// interval-free double arithmetic with u kept as a factor, and holds core/trace/bounds.h to them.

#include "core/trace/bounds.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/geometry/rounding.h"

namespace sightline {
namespace {

using namespace bounds;

/// "1+": more than every product of the small factors (1 + c u) that the proofs drop.
constexpr double kPlus = 1 + 0x1p-40;

/// Lemma 1, in units of u R: corner seen from the origin, and a sheared coordinate.
constexpr double kSeen = 1 + 1;  // rounding of the difference, anchor error
constexpr double kShear = 2;     // rounded inverse, rounded product
constexpr double kSheared = (kSeen + kShear) + 1 + kSeen + 2;  // s Z, its rounding, first term, sum

TEST(Bounds, slack_covers_twice_the_error_of_a_sheared_coordinate) {
  EXPECT_GE(kSlack * (1 - 0x1p-40), 2 * kSheared * kPlus);
}

TEST(Bounds, sign_factor_covers_theorem_1) {
  const double propagated = 4 * kSheared;                   // of u R M
  const double rounded = 4 * 2;                             // 4 u M^2, M <= 2 R
  const double squared = 2 * kSheared * kSheared / kSlack;  // 2 D^2 with u R <= m / slack
  EXPECT_GE(kSign, (propagated + rounded + squared) * kPlus);
}

TEST(Bounds, t_width_covers_theorem_2) {
  const double seen = kSeen, top = 3, bottom = 2;
  const double with_s = seen + top + bottom;  // of u R S
  const double finish = 4 + 1;                // inverse, two products, 1 / dz; subtracting h
  EXPECT_GE(kTau, (with_s + finish) * kPlus);
  EXPECT_GE(kTauReach, 6 * with_s * kPlus);  // S <= |D| + 6 E
  EXPECT_GE(kTauEdge, 3 * kPlus);
}

TEST(Bounds, floors_cover_underflow) {
  // Theorem 1: M 2^-1071 for M up to 2^110, twice over; beyond, the margin of the sign factor.
  EXPECT_GE(kSignFloor / 2, 0x1p110 * 0x1p-1071);
  EXPECT_GE((kSign - 56) * kU * 0x1p108, 0x1p-1071);
}

TEST(Bounds, nothing_overflows_within_the_reach_of_the_filter) {
  // w is two products of X, Y <= 2 R, and sum w Z three products of w and Z <= R.
  const double w = 2 * (2 * kFilterReach) * (2 * kFilterReach);
  EXPECT_LT(3 * w * kFilterReach * kPlus, std::numeric_limits<double>::max());
}

TEST(Bounds, floors_cover_what_directions_lose_below_the_normal_range) {
  EXPECT_GE(kDirectionFloor, 0x1p-1074);  // twice the half unit that rounding costs
  // Three products of a component, each off by half a unit; sums do not underflow inexactly.
  EXPECT_GE(kMappedFloor, 3 * 0x1p-1074);
  // In the units of a float32 mesh, whose scale is at most 2^150; and once more after scaling.
  EXPECT_GE(kPad, kMappedTau * kMappedFloor * 0x1p150);
  EXPECT_GE(kPad, kMappedTau * kDirectionFloor);
}

TEST(Bounds, box_steps_cover_theorem_3) {
  const double half_ulp = 0x1p-24;
  // Difference, product, rounding of the inverse.
  EXPECT_GE(1 - (1 - kInverseStep) * (1 + half_ulp) * (1 + half_ulp) * (1 + half_ulp), 0);
  EXPECT_GE((1 + kInverseStep) * (1 - half_ulp) * (1 - half_ulp) * (1 - half_ulp), 1);
  // An origin's step survives its rounding to float32.
  EXPECT_GE(kOriginStep * (1 - 0x1p-20), half_ulp * (1 + kOriginStep));
  EXPECT_GE(kLimitStep * (1 - 0x1p-20), half_ulp * (1 + kLimitStep));
  EXPECT_GE(kPad / 2 * (1 - half_ulp), 0x1p-149);
  EXPECT_GE(kLimitFloor, 0x1p-149);
}

TEST(Bounds, anchors_and_mapped_rays_are_covered) {
  EXPECT_GE(kEnter, 3 * kU);
  EXPECT_GE(kAnchor, 4 * kU * kU * 2);
  EXPECT_GE(kMapped, (4 + 3) * kPlus);
}

TEST(Bounds, double_double_covers_theorem_5) {
  const double u2 = kU * kU;
  const double normal = 5 + 4;
  const double sum = normal + 5 + 2 * 4;
  EXPECT_GE(kDoubleDouble, (sum + 2) * u2 * kPlus);
  const double lower_parts = 1 + 1 + 1 + 1;
  const double dot = normal + 7 * lower_parts + 1 + (lower_parts + 1);
  EXPECT_GE(kDoubleDouble, dot * u2 * kPlus);
  // A single ray: normals that are not normalised, and both sums without compensation of low parts.
  EXPECT_GE(normal, 5 + 3);
  const double top_lows = 1 + 2 + 1;
  const double top =
      normal + 2 + 3 + (3 + top_lows) + 2 * top_lows + (top_lows + 1) + 2 * (top_lows + 2);
  EXPECT_GE(kDoubleDouble, top * u2 * kPlus);
  const double bottom_lows = 1 + 2;
  const double bottom =
      normal + 2 + bottom_lows + 2 * bottom_lows + (bottom_lows + 1) + 2 * (bottom_lows + 2);
  EXPECT_GE(kDoubleDouble, bottom * u2 * kPlus);
  const double quotient = 3 + 3 + 4 + 4 * 2 + 4;
  EXPECT_GE(kDoubleDouble, quotient * u2 * kPlus);
}

}  // namespace
}  // namespace sightline
