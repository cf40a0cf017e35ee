#pragma once
/// The constants of the box filters, in units of the magnitudes that
/// docs/explanation/exactness-boxes.md names. Each is proved there;
/// tests/unit/geometry/box_bounds_test.cpp derives each again.

namespace sightline::box_bounds {

/// Unit roundoff of float64.
inline constexpr double kU = 0x1p-53;

// Ray against axis-aligned planes.
inline constexpr double kCrossingSlack = 4 * kU;        ///< times |T|
inline constexpr double kCrossingFloor = 0x1p-1072;     ///< what underflow takes
inline constexpr double kProductsSlack = 64 * kU * kU;  ///< times S
inline constexpr double kGapSlack = 4 * kU;             ///< times |gap|
inline constexpr double kRefineSlack = 8 * kU;          ///< times |c|
inline constexpr double kRefineFloor = 0x1p-1073;

// Batches of rays and axis-aligned boxes: factors and products of TwoProduct.
inline constexpr double kProductLeast = 0x1p-900;
inline constexpr double kProductMost = 0x1p900;

// Ray against oriented planes.
inline constexpr double kSumSlack = 256 * kU * kU;      ///< times M
inline constexpr double kSumFloor = 0x1p-1073;          ///< per product that underflows
inline constexpr double kQuotientSlack = 64 * kU * kU;  ///< times |T|
inline constexpr double kQuotientFactor = 1.25;         ///< of the errors of n and r
inline constexpr double kQuotientFloor = 0x1p-1060;
inline constexpr double kRateError = 0x1p-4;  ///< of the rate, at most

// Triangle against box.
inline constexpr double kPlacedSlack = 8 * kU;  ///< of |a| |v - c|, summed over the components
inline constexpr double kPlacedFloor = 0x1p-1070;
inline constexpr double kCrossDelta = 5;
inline constexpr double kCrossSlack = 16 * kU;
inline constexpr double kCrossFloor = 0x1p-1070;
inline constexpr double kNormalDelta = 3;
inline constexpr double kNormalSlack = 32 * kU;
inline constexpr double kNormalFloor = 0x1p-1060;

}  // namespace sightline::box_bounds
