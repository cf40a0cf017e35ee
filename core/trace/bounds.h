#pragma once
/// The constants of the error bounds of the float64 and float32 filters of kernels. Each comment
/// begins with the section of docs/explanation/exactness.md that proves the bound.
/// tests/unit/trace/bounds_test.cpp derives the smallest values that the proofs allow. u is kU of
/// rounding.h. tau, reach and anchor are those of ray_setup.h.

namespace sightline::bounds {

/// More than underflow takes from a coordinate or from a sum of products: in units of the mesh, and
/// in units of a scaled tree, in which coordinates reach 1.
inline constexpr double kUnderflow = 0x1p-1000;
inline constexpr double kScaledUnderflow = 0x1p-100;

// "Triangles", signs: an edge function is off by at most E = kSign * u * R * m + kSignFloor, where
// m = |corner 0| + 2 edge + kSlack * u * R. R is the ray's reach, edge the largest |component| of
// an edge.
inline constexpr double kSign = 64;
inline constexpr double kSlack = 32;
inline constexpr double kSignFloor = 0x1p-960;

/// "Vertex culling": edge functions of a packet are off by at most kVertexCulling * u * R^2 +
/// kSignFloor.
inline constexpr double kVertexCulling = 128;

/// Beyond this reach, products of four coordinates may overflow, so the filter decides nothing.
inline constexpr double kFilterReach = 0x1p320;

// "Triangles", t: the interval of tau has the half width (kTau u R + ((kTauEdge edge + kTauReach u
// R) E + kSignFloor) / |D|) / |dz|, where D is the sum of the edge functions.
inline constexpr double kTau = 16;
inline constexpr double kTauEdge = 12;
inline constexpr double kTauReach = 128;

// "Boxes": inverse directions are widened by the factor kInverseStep, origins o move outwards by
// |o| * kOriginStep + kPad, limits of tau by |tau| * kLimitStep + kLimitFloor.
inline constexpr double kInverseStep = 0x1p-21;
inline constexpr double kOriginStep = 0x1p-23;
inline constexpr double kLimitStep = 0x1p-22;
inline constexpr double kPad = 0x1p-100;
inline constexpr double kLimitFloor = 0x1p-126;

// "Anchors": a moved origin o' is off by at most u |o'| + kAnchor (|o| + |anchor d|) + the least
// normal number.
inline constexpr double kAnchor = 0x1p-102;
/// Factor of |tau| by which the tau is lowered at which a ray enters the bounds of the scene.
inline constexpr double kEnter = 0x1p-40;

// "Anchors": the error of a component of the direction below the normal range, per unit of tau.
inline constexpr double kDirectionFloor = 0x1p-1074;

// "Instances": a ray that is mapped into a mesh's space is off by at most kMapped * u * |N| (|o| +
// reach), where N is TreeSpace::inverse and reach TreeSpace::reach. Underflow in its direction adds
// kMappedFloor per unit of tau.
inline constexpr double kMapped = 12;
inline constexpr double kMappedFloor = 0x1p-1070;
/// Up to this |tau|, kPad is larger than what underflow adds, in the units of any mesh.
inline constexpr double kMappedTau = 0x1p700;

// "Rounding t": the relative error of t in double-double.
inline constexpr double kDoubleDouble = 0x1p-100;

}  // namespace sightline::bounds
