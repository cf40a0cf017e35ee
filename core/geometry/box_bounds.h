#pragma once
/// Constants of the error bounds of the float64 filters for boxes. A filter bounds the error of a
/// computed number by slack * size + floor. `slack` is relative to the size that its comment names;
/// `floor` covers underflow. docs/explanation/exactness-boxes.md defines the sizes and proves each
/// constant; tests/unit/geometry/box_bounds_test.cpp derives each again.

#include "core/geometry/rounding.h"

namespace sightline::box_bounds {

// Ray against axis-aligned planes. A plane is crossed at T = (plane - origin) / direction. high is
// the numerator rounded to float64 and rate the denominator, both of the sign that makes rate > 0.
inline constexpr double kCrossingSlack = 4 * kU;     ///< relative to |T|: the error of T in float64
inline constexpr double kCrossingFloor = 0x1p-1072;  ///< absolute: the error of T by underflow
/// The least gap between the largest T of a near plane and the second largest, relative to the
/// bound of the error of the largest (kCrossingSlack and kCrossingFloor).
inline constexpr double kSecondSlack = 4;
/// relative to S, the sum of magnitudes of the two products high1 rate2 and high2 rate1
inline constexpr double kProductsSlack = 64 * kU * kU;
/// relative to |gap|, the computed difference that is compared with zero
inline constexpr double kGapSlack = 4 * kU;
/// relative to |c|, the correction that refines T to 100 bits
inline constexpr double kRefineSlack = 8 * kU;
/// absolute: the error of the correction by underflow
inline constexpr double kRefineFloor = 0x1p-1073;

// Batches of rays and axis-aligned boxes. TwoProduct (two_product of error_free.h) is exact on
// every instruction set under two conditions. Both factors are at most kProductMost, and the
// product is in [kProductLeast, kProductMost], in magnitude.
inline constexpr double kProductLeast = 0x1p-900;
inline constexpr double kProductMost = 0x1p900;

// Ray against oriented planes: double-double sums, and quotients of two of them.
/// relative to M, the sum of magnitudes of the terms of a sum
inline constexpr double kSumSlack = 256 * kU * kU;
inline constexpr double kSumFloor = 0x1p-1073;  ///< absolute, for each product that underflows
inline constexpr double kQuotientSlack = 64 * kU * kU;  ///< relative to |T|, the quotient
/// relative to (error of numerator + |T| error of denominator) / denominator
inline constexpr double kQuotientFactor = 1.25;
/// absolute, times 1 + 1 / denominator: what underflow adds to a quotient
inline constexpr double kQuotientFloor = 0x1p-1060;
/// the largest relative error of a denominator; beyond it a quotient is unknown
inline constexpr double kRateError = 0x1p-4;

// Triangle against box. D_i are the triangle's extents, delta_i the errors of its corners.
/// delta: relative to |a| |v - c| summed over the components, for a corner v in the axes a of a box
/// at c
inline constexpr double kPlacedSlack = 8 * kU;
inline constexpr double kPlacedFloor = 0x1p-1070;  ///< delta: absolute
/// cross products of edges: relative to D_i delta_j + D_j delta_i
inline constexpr double kCrossDelta = 5;
inline constexpr double kCrossSlack = 16 * kU;    ///< cross products of edges: relative to D_i D_j
inline constexpr double kCrossFloor = 0x1p-1070;  ///< cross products of edges: absolute
inline constexpr double kNormalDelta = 3;  ///< the triangle's normal: relative to D_i D_j delta_k
inline constexpr double kNormalSlack = 32 * kU;  ///< the triangle's normal: relative to D_x D_y D_z
inline constexpr double kNormalFloor = 0x1p-1060;  ///< the triangle's normal: absolute

}  // namespace sightline::box_bounds
