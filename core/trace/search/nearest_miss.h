#pragma once
/// Finds the triangle to which a ray without a hit comes nearest.

#include <optional>

#include "core/base/deadline.h"
#include "core/geometry/point_triangle.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

/// The result.
struct NearestMiss {
  TriangleId id;
  /// interval of the distance between the triangle and the ray within its limits
  DistanceRange distance;
};

/// Returns the nearest of the triangles of which any side counts, by float64 arithmetic; at equal
/// distance the smallest id. It explains a miss to people, and is not exact. Empty if built trees
/// contain no such triangle. The result must not be used if the deadline passed. Throws
/// std::bad_alloc.
std::optional<NearestMiss> nearest_miss(const SceneView& scene, const Ray& ray,
                                        const ResolvedFilter* resolved, const Deadline& deadline);

}  // namespace sightline

// Tests: tests/integration/filters_test.py
