#pragma once
/// Rays at the places of a scene where arithmetic is hard.

#include <array>
#include <span>

#include "core/geometry/box3.h"
#include "tests/stress/case.h"

namespace sightline::stress {

Vec3d plus(const Vec3d& a, double s, const Vec3d& b);  ///< a + s b, rounded as written
Vec3d minus(const Vec3d& a, const Vec3d& b);
Vec3d cross(const Vec3d& a, const Vec3d& b);
double length(const Vec3d& v);
Vec3d scaled(const Vec3d& v, double s);
Vec3d as_float32(const Vec3d& v);

/// v0 + a (v1 - v0) + b (v2 - v0), rounded as written: exact for small dyadic weights and float32
/// corners of like magnitude.
Vec3d point_of(const Triangle& triangle, double a, double b);
std::array<Vec3d, 3> corners(const Triangle& triangle);

/// The finite triangles of a scene and where they are, with ways to aim at them.
class Aim {
 public:
  /// Precondition: at least one triangle is finite.
  Aim(const SceneDescription& scene, Random& random);

  const std::vector<Triangle>& triangles() const { return triangles_; }
  const Box3d& box() const { return box_; }
  double size() const { return size_; }  ///< the longest side of the box
  const Vec3d& middle() const { return middle_; }
  Random& random() const { return random_; }

  const Triangle& triangle() const;
  Vec3d corner() const;
  /// On an edge: a dyadic or any fraction of the way.
  Vec3d edge_point() const;
  /// In the inside: dyadic or any weights.
  Vec3d inner_point() const;

  /// Uniform in the box of the scene, enlarged by `margin` of its size on every side.
  Vec3d around(double margin) const;
  /// A float32 ray from somewhere near the scene that aims at the target and, when target and
  /// steps allow, passes through it exactly: float32 origin and direction, target = o + t d.
  Ray exactly_at(const Vec3d& target) const;
  /// The same in float64 numbers, any origin; direction = target - origin as rounded.
  Ray at(const Vec3d& target, double margin = 1) const;
  /// Pixel i of n of a pinhole view from outside towards the middle.
  Ray pixel(const Vec3d& eye, std::size_t i, std::size_t n) const;

 private:
  std::vector<Triangle> triangles_;
  Box3d box_;
  double size_ = 1;
  double quantum_ = 1;
  Vec3d middle_;
  Random& random_;
};

/// Moves every component by up to `steps` float64 numbers either way.
Vec3d nudged(Random& random, Vec3d v, int steps);

/// Sets a direction that became zero to the x axis: every ray passes the border check.
void ensure_valid(Ray& ray);

}  // namespace sightline::stress
