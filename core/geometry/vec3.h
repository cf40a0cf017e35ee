#pragma once
/// Three-component vectors of float32 and float64. They have no arithmetic operators on purpose:
/// exact code writes each operation, and so each rounding, itself.

namespace sightline {

/// operator[]: the component of an axis, 0 (x), 1 (y) or 2 (z).
struct Vec3f {
  float x = 0, y = 0, z = 0;
  float operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  bool operator==(const Vec3f&) const = default;
};

/// operator[]: the component of an axis, 0 (x), 1 (y) or 2 (z).
struct Vec3d {
  double x = 0, y = 0, z = 0;
  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  bool operator==(const Vec3d&) const = default;
};

}  // namespace sightline

// Tests: tests/unit/geometry/ray_box_test.cpp
