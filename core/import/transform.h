#pragma once
/// Node transforms as float64 matrices, by formulas that anyone can recompute.

#include <tiny_gltf.h>

#include <cstddef>
#include <string>

#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/geometry/vec3.h"

namespace sightline::gltf {

/// Translation t, rotation (x, y, z, w) and scale s, in float64 without FMA, in this order:
///   x2 = x + x    y2 = y + y    z2 = z + z
///   xx = x * x2   xy = x * y2   xz = x * z2   yy = y * y2   yz = y * z2   zz = z * z2
///   wx = w * x2   wy = w * y2   wz = w * z2
///   | (1 - (yy + zz)) * sx    (xy - wz) * sy          (xz + wy) * sz          tx |
///   | (xy + wz) * sx          (1 - (xx + zz)) * sy    (yz - wx) * sz          ty |
///   | (xz - wy) * sx          (yz + wx) * sy          (1 - (xx + yy)) * sz    tz |
/// The quaternion is taken as it stands, not normalised: that is what the file says, and what other
/// readers do.
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};
Affine from_trs(const Vec3d& t, const Quaternion& q, const Vec3d& s);

/// The node's matrix (column by column in the file, last row 0 0 0 1), or its TRS, or the identity.
/// Errors: GLTF_TRANSFORM_INVALID: a number beyond float32's range, a rotation of zero, a last row
/// that is not 0 0 0 1.
/// warning  set when the rotation's squared length is not within 1% of 1
Result<Affine> node_matrix(const tinygltf::Node& node, std::size_t index, std::string& warning);

/// Whether all numbers are finite and within float32's range: then world positions stay far from
/// overflow.
bool is_in_range(const Affine& matrix);

}  // namespace sightline::gltf
