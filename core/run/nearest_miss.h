#pragma once
/// The triangle that a ray without a hit comes nearest to, in a scene that may have unbuilt trees.

#include <optional>

#include "core/run/engine.h"
#include "core/trace/search/nearest_miss.h"

namespace sightline {

/// Among the triangles of which any side is in options.resolved; see core/trace/search/nearest_miss.h. Errors:
/// those of Engine::sweep.
Status nearest_miss(const Engine& engine, const Scene& scene, const Ray& ray,
                    const RayOptions& options, const Deadline& deadline,
                    std::optional<NearestMiss>& miss);

}  // namespace sightline

// Tests: tests/integration/filters_test.py
