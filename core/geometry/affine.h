#pragma once
/// A float64 3x4 matrix, rows of (m0 m1 m2 m3), applied exactly as the contract states it.

#include <cstddef>

#include "core/geometry/vec3.h"

namespace sightline {

struct Affine {
  double m[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

  /// world = m0*x + m1*y + m2*z + m3, float64, left to right, no FMA (docs/reference/contract.md,
  /// "The scene", 3). Anyone can recompute it; the resulting float64 triangles are the scene.
  Vec3d apply(const Vec3d& p) const {
    return {((m[0][0] * p.x + m[0][1] * p.y) + m[0][2] * p.z) + m[0][3],
            ((m[1][0] * p.x + m[1][1] * p.y) + m[1][2] * p.z) + m[1][3],
            ((m[2][0] * p.x + m[2][1] * p.y) + m[2][2] * p.z) + m[2][3]};
  }
  Vec3d apply(const Vec3f& p) const {
    return apply(
        Vec3d{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
  }

  /// parent * child: 4x4 product with the implied last row (0 0 0 1), each sum left to right.
  friend Affine operator*(const Affine& a, const Affine& b) {
    Affine r;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 4; ++j) {
        double sum = (a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j]) + a.m[i][2] * b.m[2][j];
        r.m[i][j] = j == 3 ? sum + a.m[i][3] : sum;
      }
    }
    return r;
  }
  bool operator==(const Affine&) const = default;
  bool is_identity() const { return *this == Affine{}; }
  /// Only scales the axes and moves: each world coordinate comes from one mesh coordinate.
  bool is_diagonal() const {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 3; ++j) {
        if (j != k && m[k][j] != 0) return false;
      }
    }
    return true;
  }
};

}  // namespace sightline

// Tests: tests/unit/geometry/normal_map_test.cpp
