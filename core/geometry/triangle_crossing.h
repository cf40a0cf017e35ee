#pragma once
/// Tests exactly whether two triangles cross: they do not lie in one plane, and their interiors
/// (without edges) have a common point.
///
/// Method   each triangle has corners strictly on both sides of the other one's plane, and the open
///          segments in which they meet the line of both planes overlap. Signs of volumes of four
///          corners decide both [Guigue2003].
/// Filter   float64 with the error bound of [Shewchuk1997], then Dyadic numbers.

#include "core/geometry/dyadic.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The number (b - a) . ((c - a) x (d - a)), six times the signed volume of four points, by float64
/// arithmetic: it is within `error` of `value`.
struct VolumeEstimate {
  double value = 0;
  double error = 0;

  /// The sign of the exact number if it is certain, else 0.
  int certain_sign() const {
    if (value > error) return 1;
    return value < -error ? -1 : 0;
  }
};
VolumeEstimate estimate_volume(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);
/// Returns the same number, exactly. Precondition: finite.
Dyadic exact_volume(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

/// The sign of (b - a) . ((c - a) x (d - a)): 1 if d is on the side of the plane of a, b, c from
/// which they run counter-clockwise, 0 on the plane, -1 on the other side. Precondition: finite.
int volume_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

/// True if the triangles cross. Preconditions: both are finite and have an area.
bool triangles_cross(const Triangle& a, const Triangle& b);

}  // namespace sightline

// Tests: tests/unit/geometry/triangle_crossing_test.cpp
