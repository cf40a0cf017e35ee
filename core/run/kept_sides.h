#pragma once
/// A filter of hits, worked out for one scene.

#include <string>

#include "core/base/result.h"
#include "core/query/hit_filter.h"
#include "core/scene/scene.h"

namespace sightline {

/// Errors: FILTER_NODE_UNKNOWN, with a pointer to the number in "include" or "exclude". A glob may
/// match nothing. Throws std::bad_alloc.
/// Cost: linear in nodes times patterns, and in instances.
Result<KeptSides> kept_sides(const Scene& scene, const HitFilter& filter);

/// All sides of what one choice names. Errors: as above, below `key`.
Result<KeptSides> chosen_sides(const Scene& scene, const TriangleChoice& choice,
                               const std::string& key);

}  // namespace sightline
