#pragma once
/// A filter of hits, worked out for one scene.

#include <optional>
#include <span>
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
/// The same for rays that may have masks; nothing where all triangles count for all of them, so
/// that nobody looks for what is not there. `ray_masks` may be empty.
Result<std::optional<KeptSides>> kept_for_rays(const Scene& scene, const HitFilter& filter,
                                               std::span<const std::uint32_t> ray_masks);

}  // namespace sightline
