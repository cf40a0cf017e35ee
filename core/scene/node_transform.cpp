#include "core/scene/node_transform.h"

#include <charconv>
#include <cmath>
#include <limits>

namespace sightline {

namespace {

constexpr double kLargest = static_cast<double>(std::numeric_limits<float>::max());

Error wrong_transform(std::string what, const char* member) {
  return {ErrorKind::kInvalid, "TRANSFORM_INVALID", std::move(what), member};
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

Result<Affine> matrix_of(const NodeTransform& transform) {
  const auto& [m, t, r, s] = transform;
  for (const auto& [numbers, member] : {std::pair{&m, "/matrix"}, std::pair{&t, "/translation"},
                                        std::pair{&r, "/rotation"}, std::pair{&s, "/scale"}}) {
    for (const double value : *numbers) {
      if (std::fabs(value) <= kLargest) continue;
      return wrong_transform(
          "its transform holds " + decimal(value) + ", more than a float32 can hold", member);
    }
  }
  if (!m.empty()) {
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) {
      return wrong_transform("the last row of its matrix must be 0 0 0 1", "/matrix");
    }
    Affine matrix;
    for (std::size_t column = 0; column < 4; ++column) {
      for (std::size_t row = 0; row < 3; ++row) matrix.m[row][column] = m[column * 4 + row];
    }
    return matrix;
  }
  Quaternion turn;
  if (!r.empty()) turn = {r[0], r[1], r[2], r[3]};
  if (turn.norm() == 0) return wrong_transform("its rotation is zero", "/rotation");
  return from_trs(t.empty() ? Vec3d{} : Vec3d{t[0], t[1], t[2]}, turn,
                  s.empty() ? Vec3d{1, 1, 1} : Vec3d{s[0], s[1], s[2]});
}

std::string decimal(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

}  // namespace sightline
