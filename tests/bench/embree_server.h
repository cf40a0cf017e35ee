#pragma once
/// What one would write oneself: Embree's single rays behind the same server, JSON by nlohmann's
/// DOM.

#include "core/scene/scene.h"

namespace sightline::bench {

/// Answers POST /v1/scenes/bench/rays:closest, rows or columns, as Sightline does with the fields
/// t, instance, primitive and triangle. Does not return.
void serve_embree(const Scene& scene, int workers, int port);

}  // namespace sightline::bench
