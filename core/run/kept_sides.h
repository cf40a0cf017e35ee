#pragma once
/// A filter of hits, worked out for one scene.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/scene/scene.h"

namespace sightline {

// All of these ask for the memory that they take, and end with DEADLINE or CANCELLED where the time
// was used up.

/// What one of them holds, at most.
std::uint64_t kept_sides_bytes(const Scene& scene);

/// Errors: FILTER_NODE_UNKNOWN, with a pointer to the number in "include" or "exclude". A glob may
/// match nothing. Throws std::bad_alloc.
/// Cost: linear in nodes times patterns (of names that come again mostly once), and in instances.
Result<KeptSides> kept_sides(const Scene& scene, const HitFilter& filter, const Deadline& deadline,
                             const ReserveBytes& reserve);

/// All sides of what one choice names. Errors: as above, below `key`.
Result<KeptSides> chosen_sides(const Scene& scene, const TriangleChoice& choice,
                               const std::string& key, const Deadline& deadline,
                               const ReserveBytes& reserve);
/// The same for rays that may have masks; nothing where all triangles count for all of them, so
/// that nobody looks for what is not there. `ray_masks` may be empty.
Result<std::optional<KeptSides>> kept_for_rays(const Scene& scene, const HitFilter& filter,
                                               std::span<const std::uint32_t> ray_masks,
                                               const Deadline& deadline,
                                               const ReserveBytes& reserve);

}  // namespace sightline
