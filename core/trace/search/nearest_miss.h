#pragma once
/// Finds the triangle to which a ray without a hit comes nearest, to explain the miss to people.

#include <optional>

#include "core/base/deadline.h"
#include "core/geometry/point_triangle.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

/// The triangle to which a ray comes nearest.
struct NearestMiss {
  TriangleId id;
  /// interval of the distance between the triangle and the ray within its limits, in scene units
  DistanceRange distance;
};

/// Returns the nearest of the triangles of which any side counts, by float64 arithmetic; at equal
/// distance the smallest id. It is not exact. `resolved` may be null: all triangles count. Unbuilt
/// trees are searched as empty; the result is empty if there is no triangle. It must not be used if
/// the deadline passed. Precondition: the ray has passed check_rays. Throws std::bad_alloc.
std::optional<NearestMiss> nearest_miss(const SceneView& scene, const Ray& ray,
                                        const ResolvedFilter* resolved, const Deadline& deadline);

}  // namespace sightline

// Tests: tests/integration/filters_test.py
