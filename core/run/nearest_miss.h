#pragma once
/// Finds the triangle to which a ray without a hit comes nearest, to explain the miss. Builds the
/// trees that the search needs.

#include <optional>

#include "core/run/engine.h"
#include "core/trace/search/nearest_miss.h"

namespace sightline {

/// Considers triangles of which options.resolved (null: all) has any side;
/// core/trace/search/nearest_miss.h has the definition. `miss` is set, or emptied if there is no
/// triangle. Precondition: the ray has passed check_rays. Errors: those of Engine::sweep.
Status nearest_miss(const Engine& engine, const Scene& scene, const Ray& ray,
                    const RayOptions& options, const Deadline& deadline,
                    std::optional<NearestMiss>& miss);

}  // namespace sightline

// Tests: tests/integration/filters_test.py
