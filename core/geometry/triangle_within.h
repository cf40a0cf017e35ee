#pragma once
/// Tests exactly whether a point or a closed triangle lies wholly within a closed convex region. A
/// triangle does if its corners do. The region's surface belongs to it.

#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/triangle.h"
#include "core/geometry/triangle_capsule.h"
#include "core/geometry/triangle_convex.h"
#include "core/geometry/triangle_sphere.h"

namespace sightline {

/// True if the region contains p. Preconditions: p is finite, and the region satisfies the
/// preconditions of its type.
bool is_within(const Vec3d& p, const Box3d& box);
bool is_within(const Vec3d& p, const OrientedBox& box);
bool is_within(const Vec3d& p, const Sphere& sphere);
bool is_within(const Vec3d& p, const Capsule& capsule);
bool is_within(const Vec3d& p, const ConvexRegion& region);

/// True if all three corners of the triangle lie within the region. False if a corner is not
/// finite. The triangle's area is not tested.
template <class Region>
bool corners_within(const Triangle& t, const Region& region) {
  return is_finite(t) && is_within(t.v0, region) && is_within(t.v1, region) &&
         is_within(t.v2, region);
}

}  // namespace sightline

// Tests: tests/unit/trace/box_overlap_test.cpp
