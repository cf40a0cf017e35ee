#pragma once
/// Every constant of every filter, with its place in docs/explanation/exactness.md, which proves
/// them; a test (tests/unit/trace/bounds_test.cpp) derives the smallest value that the proofs
/// allow.

namespace sightline::bounds {

/// Half the distance from 1 to the next float64.
inline constexpr double kU = 0x1p-53;

// "Triangles", signs: E = kSign * u * R * m + kSignFloor, m = |corner 0| + 2 edge + kSlack * u * R.
inline constexpr double kSign = 64;
inline constexpr double kSlack = 32;
inline constexpr double kSignFloor = 0x1p-960;

/// "Vertex culling": edge functions of many rays are off by at most kVertexCulling * u * R^2 + kSignFloor.
inline constexpr double kVertexCulling = 128;

/// Beyond this reach products of four coordinates may overflow: nothing is decided by the filter.
inline constexpr double kFilterReach = 0x1p320;

// "Triangles", t: half width = (kTau u R + ((kTauEdge edge + kTauReach u R) E + kSignFloor) / |D|)
// / |dz|.
inline constexpr double kTau = 16;
inline constexpr double kTauEdge = 12;
inline constexpr double kTauReach = 128;

// "Boxes": inverses are widened by kInverseStep, origins move outwards by |o| * kOriginStep + kPad.
inline constexpr double kInverseStep = 0x1p-21;
inline constexpr double kOriginStep = 0x1p-23;
inline constexpr double kLimitStep = 0x1p-22;
inline constexpr double kPad = 0x1p-100;
inline constexpr double kLimitFloor = 0x1p-126;

// "Anchors": e = u |o'| + kAnchor (|o| + |anchor d|) + the least normal number.
inline constexpr double kAnchor = 0x1p-102;
inline constexpr double kEnter = 0x1p-40;

// "Anchors": what a component of the direction below the normal range may be off, per unit of tau.
inline constexpr double kDirectionFloor = 0x1p-1074;

// "Instances": what a mapped ray may be off, in u times |N| (|o| + reach), and what underflow in
// its direction may add, per unit of tau.
inline constexpr double kMapped = 12;
inline constexpr double kMappedFloor = 0x1p-1070;
/// Up to this |tau| kPad covers that floor, in the units of any mesh.
inline constexpr double kMappedTau = 0x1p700;

// "Rounding t": error of t in double-double.
inline constexpr double kDoubleDouble = 0x1p-100;

}  // namespace sightline::bounds
