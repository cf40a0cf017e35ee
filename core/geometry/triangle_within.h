#pragma once
/// Whether a closed triangle lies wholly within a closed convex region, exactly: it does if its
/// corners do. The border belongs to the region.

#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/triangle.h"
#include "core/geometry/triangle_capsule.h"
#include "core/geometry/triangle_convex.h"
#include "core/geometry/triangle_sphere.h"

namespace sightline {

/// Preconditions: p is finite, the region as its query has checked it.
bool is_within(const Vec3d& p, const Box3d& box);
bool is_within(const Vec3d& p, const OrientedBox& box);
bool is_within(const Vec3d& p, const Sphere& sphere);
bool is_within(const Vec3d& p, const Capsule& capsule);
bool is_within(const Vec3d& p, const ConvexRegion& region);

/// Whether a triangle lies inside of the region. A triangle with a corner that is not finite lies
/// inside of none. The area is not tested.
template <class Region>
bool corners_within(const Triangle& t, const Region& region) {
  return is_finite(t) && is_within(t.v0, region) && is_within(t.v1, region) &&
         is_within(t.v2, region);
}

}  // namespace sightline

// Tests: tests/unit/trace/box_overlap_test.cpp
