#include "core/geometry/normal_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/dyadic.h"

namespace sightline {
namespace {

/// a * b - c * d within 1.5 units in the last place [JeannerodLouvetMuller2013].
double difference_of_products(double a, double b, double c, double d) {
  const double cd = c * d;
  const double lost = std::fma(-c, d, cd);
  return std::fma(a, b, -cd) + lost;
}

/// The power of two that brings the largest of the magnitudes to [1/2, 1); 0 when all are zero.
int exponent_of(double largest) {
  int exponent = 0;
  std::frexp(largest, &exponent);
  return exponent;
}

Dyadic product(double a, double b, double c) { return Dyadic(a) * Dyadic(b) * Dyadic(c); }

bool is_reflection(const double (&m)[3][3], const double (&cofactor)[3][3]) {
  double sum = 0, size = 0;
  for (int j = 0; j < 3; ++j) {
    sum += m[0][j] * cofactor[0][j];
    size += std::abs(m[0][j] * cofactor[0][j]);
  }
  if (std::abs(sum) > size * 0x1p-49) return sum < 0;
  const Dyadic exact = product(m[0][0], m[1][1], m[2][2]) + product(m[0][1], m[1][2], m[2][0]) +
                       product(m[0][2], m[1][0], m[2][1]) - product(m[0][2], m[1][1], m[2][0]) -
                       product(m[0][1], m[1][0], m[2][2]) - product(m[0][0], m[1][2], m[2][1]);
  return exact.sign() < 0;
}

}  // namespace

NormalMap::NormalMap(const Affine& affine) {
  double largest = 0, m[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) largest = std::max(largest, std::abs(affine.m[i][j]));
  }
  const int exponent = exponent_of(largest);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[i][j] = std::ldexp(affine.m[i][j], -exponent);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
      m_[i][j] = difference_of_products(m[a][c], m[b][d], m[a][d], m[b][c]);
    }
  }
  is_mirror_ = is_reflection(m, m_);
  if (!is_mirror_) return;
  for (auto& row : m_) {
    for (double& element : row) element = -element;
  }
}

Vec3d NormalMap::apply(const Vec3d& normal) const {
  Vec3d n;
  for (int i = 0; i < 3; ++i) {
    n[i] = (m_[i][0] * normal.x + m_[i][1] * normal.y) + m_[i][2] * normal.z;
  }
  return unit_or_nan(n);
}

Vec3d unit_or_nan(const Vec3d& direction) {
  Vec3d n = direction;
  const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  if (!(largest > 0) || !std::isfinite(n.x) || !std::isfinite(n.y) || !std::isfinite(n.z)) {
    return {kNan, kNan, kNan};
  }
  const int exponent = exponent_of(largest);
  for (int i = 0; i < 3; ++i) n[i] = std::ldexp(n[i], -exponent);
  const double length = std::sqrt((n.x * n.x + n.y * n.y) + n.z * n.z);
  return {n.x / length, n.y / length, n.z / length};
}

}  // namespace sightline
