#pragma once
/// Closed triangle against closed box, exactly: touching counts.
///
/// Method   separating axes [AkenineMoeller2001]: the box's three normals, the triangle's, and the
///          nine cross products of edges. An oriented box is an axis-aligned one in the coordinates
///          s_k = a_k . (p - c), a linear map under which a triangle stays a triangle.
/// Filter   float64, after the box was cut to the bounds of the triangle. That does not change
///          which points both have in common, so all magnitudes are the triangle's extents D_x,
///          D_y, D_z. Let corners be known up to delta (0 for an axis-aligned box), and u = 2^-53.
///          The two numbers that decide on a cross product with axis k are within
///              B_ij = 5 (D_i delta_j + D_j delta_i) + 16 u D_i D_j + 2^-1070
///          of the exact values. The numbers for the triangle's normal are within
///              sum_k D_k B_ij + 3 sum_k D_i D_j delta_k + 32 u D_x D_y D_z + 2^-1060.
///          Comparisons that the filter leaves open are decided in Dyadic numbers.
/// Proofs   docs/explanation/exactness-boxes.md.

#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// True if triangle and box have at least one point in common. False for a triangle that has
/// exactly no area or a corner that is not finite: such triangles are not part of a scene.
/// Preconditions: those that ray_box has for boxes.
/// Cost     about 50 ns where the filter decides; some microseconds where they nearly touch.
bool triangle_meets_box(const Triangle& triangle, const Box3d& box);
bool triangle_meets_box(const Triangle& triangle, const OrientedBox& box);

/// The two stages of triangle_meets_box, for tests. kOpen: the filter does not decide.
/// Preconditions: the corners are finite, and those of triangle_meets_box.
enum class OverlapVerdict { kApart, kMeet, kOpen };
OverlapVerdict filter_triangle_box(const Triangle& triangle, const Box3d& box);
OverlapVerdict filter_triangle_box(const Triangle& triangle, const OrientedBox& box);
bool exact_triangle_box(const Triangle& triangle, const Box3d& box);
bool exact_triangle_box(const Triangle& triangle, const OrientedBox& box);

}  // namespace sightline
