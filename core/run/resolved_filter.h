#pragma once
/// A filter of hits, worked out for one scene.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/query/selection_warning.h"
#include "core/scene/scene.h"

namespace sightline {

// All of these ask for the memory that they take, and end with DEADLINE or CANCELLED where the time
// was used up.

/// The most bytes that a resolved filter of the scene takes.
std::uint64_t resolved_filter_bytes(const Scene& scene);

// A pattern that matches no name of the scene, and a choice that has no triangle although none of
// its lists is empty, adds an entry to `warnings`. Without `warnings` it is an error,
// SELECTION_EMPTY, with its pointer: for a strict question, and for an answer that has no place for
// a warning.

/// Resolves a filter for a scene. Errors: FILTER_NODE_UNKNOWN, with a pointer to the number in
/// "include" or "exclude", and SELECTION_EMPTY. Throws std::bad_alloc. Cost: linear in instances,
/// and in nodes times patterns (repeated names mostly count once). A list with warnings takes some
/// milliseconds more for similar names.
Result<ResolvedFilter> resolve_filter(const Scene& scene, const HitFilter& filter,
                                      const Deadline& deadline, const ReserveBytes& reserve,
                                      SelectionWarnings* warnings = nullptr);

/// All sides of what one choice names. Errors: those of resolve_filter, below `key`.
Result<ResolvedFilter> chosen_sides(const Scene& scene, const TriangleChoice& choice,
                                    const std::string& key, const Deadline& deadline,
                                    const ReserveBytes& reserve,
                                    SelectionWarnings* warnings = nullptr);
/// resolve_filter for rays that may have masks. Empty where all triangles count for all rays, which
/// spares the kernels the test. `ray_masks` may be empty.
Result<std::optional<ResolvedFilter>> resolve_for_rays(const Scene& scene, const HitFilter& filter,
                                                       std::span<const std::uint32_t> ray_masks,
                                                       const Deadline& deadline,
                                                       const ReserveBytes& reserve,
                                                       SelectionWarnings* warnings = nullptr);

/// Whether both select the same triangles of their scene.
bool select_alike(const ResolvedFilter& a, const ResolvedFilter& b);

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
