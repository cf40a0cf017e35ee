#pragma once
/// Resolves a filter of hits for a scene: turns names, nodes and materials into the sides that
/// count of each primitive.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/query/selection_warning.h"
#include "core/scene/scene.h"

namespace sightline {

// All functions here that return a Result call `reserve` (null: no limit) before they allocate
// memory, and return its error. They return DEADLINE or CANCELLED if the deadline passes.

/// The most bytes that a resolved filter of the scene takes.
std::uint64_t resolved_filter_bytes(const Scene& scene);

// A pattern that matches no name of the scene appends an entry to `warnings`. So does a choice that
// selects no triangle, if none of its lists is empty and all of its patterns match. If `warnings`
// is null, both are the error SELECTION_EMPTY with a pointer: for strict requests, and for answers
// that have no place for warnings.

/// Resolves a filter, including the masks of instances. Errors: FILTER_NODE_UNKNOWN with a JSON
/// pointer to the number in "include" or "exclude", and SELECTION_EMPTY. Throws std::bad_alloc.
/// Cost: linear in instances, and in nodes times patterns (equal names are mostly matched once).
/// The search for similar names, for warnings, takes some milliseconds more.
Result<ResolvedFilter> resolve_filter(const Scene& scene, const HitFilter& filter,
                                      const Deadline& deadline, const ReserveBytes& reserve,
                                      SelectionWarnings* warnings = nullptr);

/// Returns a filter with all sides of the triangles of one choice; masks of instances are ignored.
/// `key` is the member of the request that holds the choice, for JSON pointers. Errors: those of
/// resolve_filter.
Result<ResolvedFilter> chosen_sides(const Scene& scene, const TriangleChoice& choice,
                                    const std::string& key, const Deadline& deadline,
                                    const ReserveBytes& reserve,
                                    SelectionWarnings* warnings = nullptr);
/// resolve_filter for rays with these masks; an empty `ray_masks` is no masks. The result is for
/// these rays only. It is empty if all triangles count for all rays, so that kernels need not test
/// the filter. Errors: those of resolve_filter.
Result<std::optional<ResolvedFilter>> resolve_for_rays(const Scene& scene, const HitFilter& filter,
                                                       std::span<const std::uint32_t> ray_masks,
                                                       const Deadline& deadline,
                                                       const ReserveBytes& reserve,
                                                       SelectionWarnings* warnings = nullptr);

/// By primitive of an instance: true if hits on any of its sides count. `resolved` may be null.
std::vector<bool> counting_primitives(const Scene& scene, std::size_t instance,
                                      const ResolvedFilter* resolved);

/// True if both filters of a scene have equal sides of every primitive. ResolvedFilter::masks are
/// not compared.
bool select_alike(const ResolvedFilter& a, const ResolvedFilter& b);

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
