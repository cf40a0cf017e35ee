#include "core/import/transform.h"

#include <cmath>
#include <limits>

#include "core/import/refusal.h"

namespace sightline::gltf {

namespace {

constexpr double kLargest = static_cast<double>(std::numeric_limits<float>::max());

Error wrong(std::size_t node, const std::string& what, const char* member) {
  return invalid("GLTF_TRANSFORM_INVALID", "node " + std::to_string(node) + ": " + what,
                 "/nodes/" + std::to_string(node) + member);
}

}  // namespace

Affine from_trs(const Vec3d& t, const Quaternion& q, const Vec3d& s) {
  const double x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const double xx = q.x * x2, xy = q.x * y2, xz = q.x * z2;
  const double yy = q.y * y2, yz = q.y * z2, zz = q.z * z2;
  const double wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  Affine r;
  r.m[0][0] = (1 - (yy + zz)) * s.x;
  r.m[0][1] = (xy - wz) * s.y;
  r.m[0][2] = (xz + wy) * s.z;
  r.m[0][3] = t.x;
  r.m[1][0] = (xy + wz) * s.x;
  r.m[1][1] = (1 - (xx + zz)) * s.y;
  r.m[1][2] = (yz - wx) * s.z;
  r.m[1][3] = t.y;
  r.m[2][0] = (xz - wy) * s.x;
  r.m[2][1] = (yz + wx) * s.y;
  r.m[2][2] = (1 - (xx + yy)) * s.z;
  r.m[2][3] = t.z;
  return r;
}

bool is_in_range(const Affine& matrix) {
  for (const auto& row : matrix.m) {
    for (double value : row) {
      if (!(std::fabs(value) <= kLargest)) return false;
    }
  }
  return true;
}

Result<Affine> node_matrix(const tinygltf::Node& node, std::size_t index, std::string& warning) {
  for (const auto* numbers : {&node.matrix, &node.translation, &node.rotation, &node.scale}) {
    for (double value : *numbers) {
      if (std::fabs(value) <= kLargest) continue;
      return wrong(index,
                   "its transform holds " + decimal(value) + ", more than a float32 can hold", "");
    }
  }
  if (!node.matrix.empty()) {
    const auto& m = node.matrix;
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) {
      return wrong(index, "the last row of its matrix must be 0 0 0 1", "/matrix");
    }
    Affine matrix;
    for (std::size_t column = 0; column < 4; ++column) {
      for (std::size_t row = 0; row < 3; ++row) matrix.m[row][column] = m[column * 4 + row];
    }
    return matrix;
  }
  Vec3d t, s = {1, 1, 1};
  Quaternion q;
  if (!node.translation.empty())
    t = {node.translation[0], node.translation[1], node.translation[2]};
  if (!node.scale.empty()) s = {node.scale[0], node.scale[1], node.scale[2]};
  if (!node.rotation.empty()) {
    q = {node.rotation[0], node.rotation[1], node.rotation[2], node.rotation[3]};
    const double length = ((q.x * q.x + q.y * q.y) + q.z * q.z) + q.w * q.w;
    if (length == 0) return wrong(index, "its rotation is zero", "/rotation");
    if (!(length > 0.99 && length < 1.01)) {
      warning = "node " + std::to_string(index) + ": its rotation has the squared length " +
                decimal(length) + " instead of 1 and was used as it stands";
    }
  }
  return from_trs(t, q, s);
}

}  // namespace sightline::gltf
