#pragma once
/// Matrices of nodes in float64, by formulas that anyone can recompute.

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/geometry/vec3.h"

namespace sightline {

/// A rotation as a quaternion (x, y, z, w). The default is the identity.
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
  /// The squared length, left to right.
  double norm() const { return ((x * x + y * y) + z * z) + w * w; }
};
/// Returns the matrix of a translation t, a rotation q = (x, y, z, w) and a scale s, in float64
/// without FMA, in this order:
///   x2 = x + x    y2 = y + y    z2 = z + z
///   xx = x * x2   xy = x * y2   xz = x * z2   yy = y * y2   yz = y * z2   zz = z * z2
///   wx = w * x2   wy = w * y2   wz = w * z2
///   | (1 - (yy + zz)) * sx    (xy - wz) * sy          (xz + wy) * sz          tx |
///   | (xy + wz) * sx          (1 - (xx + zz)) * sy    (yz - wx) * sz          ty |
///   | (xz - wy) * sx          (yz + wx) * sy          (1 - (xx + yy)) * sz    tz |
/// The quaternion is used without normalising, as other readers of glTF do.
Affine from_trs(const Vec3d& t, const Quaternion& q, const Vec3d& s);

/// True if all numbers are finite and within the range of float32. Then world positions are far
/// from overflow.
bool is_in_range(const Affine& matrix);

/// A transform as in glTF [glTF2] 3.5.3: `matrix` has 16 numbers, column by column, with the last
/// row 0 0 0 1; or `translation`, `rotation` and `scale` have 3, 4 and 3 numbers. A member that is
/// not given is empty.
struct NodeTransform {
  std::vector<double> matrix, translation, rotation, scale;
};
/// Returns the matrix of a transform. Errors: TRANSFORM_INVALID with the member as pointer: a
/// number beyond the range of float32, a rotation of zero, a last row that is not 0 0 0 1.
/// Precondition: each member is empty or has the length above; `matrix` or the others are empty.
Result<Affine> matrix_of(const NodeTransform& transform);

/// The shortest decimal text from which the same float64 is read.
std::string decimal(double value);

}  // namespace sightline

// Tests: tests/unit/import/transform_test.cpp
