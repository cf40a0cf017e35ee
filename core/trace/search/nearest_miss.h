#pragma once
/// The triangle that a ray without a hit comes nearest to.

#include <optional>

#include "core/base/deadline.h"
#include "core/geometry/point_triangle.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

struct NearestMiss {
  TriangleId id;
  DistanceRange distance;  ///< of the triangle from the ray, within its limits
};

/// Of the triangles that count on any side, the nearest by float64 arithmetic; at equal distance
/// the smallest id. An explanation for people, not exact. Empty if the trees that are built contain
/// none. Must not be used if the deadline passed. Throws std::bad_alloc.
std::optional<NearestMiss> nearest_miss(const SceneView& scene, const Ray& ray,
                                        const ResolvedFilter* resolved, const Deadline& deadline);

}  // namespace sightline

// Tests: tests/integration/filters_test.py
