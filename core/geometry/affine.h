#pragma once
/// Affine: a float64 3x4 matrix that maps points, for example from a mesh to the world. apply()
/// states its order of operations, because its results define the scene.

#include <cstddef>

#include "core/geometry/vec3.h"

namespace sightline {

/// An affine map of points. The default is the identity.
struct Affine {
  /// m[row][column]: row k gives coordinate k of the result; column 3 is the translation.
  double m[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

  /// Maps a point, in float64: coordinate k of the result is m[k][0] x + m[k][1] y + m[k][2] z +
  /// m[k][3], summed left to right, without FMA (docs/reference/contract.md, "The scene", 3). A
  /// scene's world triangles are computed with it.
  Vec3d apply(const Vec3d& p) const {
    return {((m[0][0] * p.x + m[0][1] * p.y) + m[0][2] * p.z) + m[0][3],
            ((m[1][0] * p.x + m[1][1] * p.y) + m[1][2] * p.z) + m[1][3],
            ((m[2][0] * p.x + m[2][1] * p.y) + m[2][2] * p.z) + m[2][3]};
  }
  /// Maps a point of float32 coordinates, which convert to float64 exactly.
  Vec3d apply(const Vec3f& p) const {
    return apply(
        Vec3d{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
  }

  /// The map that applies `b` (the child) first and `a` (its parent) afterwards: the 4x4 product
  /// with the implied last row (0 0 0 1), each sum left to right.
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
  /// True if the map changes no coordinate.
  bool is_identity() const { return *this == Affine{}; }
  /// True if the map only scales the axes and translates: each coordinate of the result depends on
  /// one coordinate of the point.
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
