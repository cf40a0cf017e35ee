#include "core/geometry/box_oriented.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/dyadic.h"

namespace sightline {

std::array<Vec3d, 3> rotated_axes(double x, double y, double z, double w) {
  const double x2 = x + x, y2 = y + y, z2 = z + z;
  const double xx = x * x2, xy = x * y2, xz = x * z2;
  const double yy = y * y2, yz = y * z2, zz = z * z2;
  const double wx = w * x2, wy = w * y2, wz = w * z2;
  return {{{1 - (yy + zz), xy + wz, xz - wy},
           {xy - wz, 1 - (xx + zz), yz + wx},
           {xz + wy, yz - wx, 1 - (xx + yy)}}};
}

bool axes_are_dependent(const std::array<Vec3d, 3>& axes) {
  const auto term = [&](int i, int j, int k) {
    return Dyadic(axes[0][i]) * Dyadic(axes[1][j]) * Dyadic(axes[2][k]);
  };
  const Dyadic determinant = (term(0, 1, 2) - term(0, 2, 1)) + (term(1, 2, 0) - term(1, 0, 2)) +
                             (term(2, 0, 1) - term(2, 1, 0));
  return determinant.sign() == 0;
}

Vec3d unit_axis(const Vec3d& axis, bool negative) {
  // Scaling by a power of two is exact but for components that are lost in the sum anyway.
  const double largest = std::max({std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)});
  const int exponent = -std::ilogb(largest);
  const double x = std::ldexp(axis.x, exponent);
  const double y = std::ldexp(axis.y, exponent);
  const double z = std::ldexp(axis.z, exponent);
  const double length = std::copysign(std::sqrt(x * x + y * y + z * z), negative ? -1.0 : 1.0);
  // Adding zero turns -0 into +0.
  return {x / length + 0.0, y / length + 0.0, z / length + 0.0};
}

}  // namespace sightline
