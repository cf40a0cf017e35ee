#pragma once
/// What a ray that meets nothing comes nearest to, in a scene whose trees may be pending.

#include <optional>

#include "core/run/engine.h"
#include "core/trace/nearest_miss.h"

namespace sightline {

/// Among the triangles that options.kept keeps on any side; see trace/nearest_miss.h. Errors: those
/// of Engine::sweep.
Status nearest_miss(const Engine& engine, const Scene& scene, const Ray& ray,
                    const RayOptions& options, const Deadline& deadline,
                    std::optional<NearestMiss>& miss);

}  // namespace sightline
