#pragma once
/// OrientedBox: a closed box with any orientation, defined by float64 numbers that anyone can
/// recompute.

#include <array>

#include "core/geometry/vec3.h"

namespace sightline {

/// The points p with |axes[k] . (p - center)| <= half[k] for k = 0, 1, 2, in real arithmetic over
/// these float64 numbers. The axes are used as they are. They need not be unit: an axis twice as
/// long makes the box half as thick. They need not be exactly orthogonal, as float64 rotations
/// never are. So the set is a parallelepiped.
/// Preconditions, which check_boxes (core/query/box_batch.h) tests: center and axes are finite, and
/// the axes do not lie in one plane. half is not negative; +inf leaves the box open along that
/// axis.
struct OrientedBox {
  Vec3d center;
  Vec3d half;
  std::array<Vec3d, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// Returns the axes of a box turned by a quaternion (x, y, z, w), in float64 without FMA, in this
/// order:
///   x2 = x + x    y2 = y + y    z2 = z + z
///   xx = x * x2   xy = x * y2   xz = x * z2   yy = y * y2   yz = y * z2   zz = z * z2
///   wx = w * x2   wy = w * y2   wz = w * z2
///   axes[0] = (1 - (yy + zz), xy + wz, xz - wy)
///   axes[1] = (xy - wz, 1 - (xx + zz), yz + wx)
///   axes[2] = (xz + wy, yz - wx, 1 - (xx + yy))
/// The quaternion is not normalised. The axes are the columns of the matrix that a glTF node with
/// this rotation has (docs/explanation/exactness-boxes.md).
std::array<Vec3d, 3> rotated_axes(double x, double y, double z, double w);

/// True if the axes lie exactly in one plane, so that they define no box. Precondition: the axes
/// are finite.
bool axes_are_dependent(const std::array<Vec3d, 3>& axes);

/// The unit vector along `axis`, or opposite to it if `negative`. Each component is within 1e-15;
/// no component is -0. Precondition: the axis is finite and not zero.
Vec3d unit_axis(const Vec3d& axis, bool negative);

}  // namespace sightline

// Tests: tests/unit/geometry/ray_box_test.cpp
