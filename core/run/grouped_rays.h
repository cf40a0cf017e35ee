#pragma once
/// Rays of one batch with filters of their own (RayOptions::groups).

#include <optional>
#include <span>
#include <vector>

#include "core/base/column.h"
#include "core/run/engine.h"
#include "core/run/resolved_filter.h"

namespace sightline {

/// The rays of a batch that share a filter.
struct FilteredRays {
  Column<std::size_t> numbers;             ///< indices of the rays, ascending
  std::optional<ResolvedFilter> resolved;  ///< for these rays; empty: all triangles count
};

/// Groups rays by filter and resolves each filter for its rays. `filter_of` has an index in
/// `filters` for each ray. A filter without rays is resolved too, for its errors and warnings; their
/// pointers begin with "/filters/list/N" for filter N. Errors: those of resolve_for_rays. Throws
/// std::bad_alloc. Cost: that of resolve_for_rays for each filter.
Result<std::vector<FilteredRays>> group_rays(const Scene& scene, const RayBatch& rays,
                                             std::span<const HitFilter> filters,
                                             std::span<const std::uint32_t> filter_of,
                                             const Deadline& deadline, const ReserveBytes& reserve,
                                             SelectionWarnings* warnings);

/// The queries of Engine with groups: each group is a query of its own, and the answers are put in
/// the order of rays. So they equal those of one query for each filter. All arguments must outlive
/// this object. Memory: a copy of the rays and answers of one group (closest, any, count), or of all
/// (all).
class GroupedRays {
 public:
  GroupedRays(const Engine& engine, const Scene& scene, const Deadline& deadline,
              const RayOptions& options)
      : engine_(engine), scene_(scene), deadline_(deadline), options_(options) {}

  // As the methods of Engine. Throw std::bad_alloc.
  Status closest(const RayBatch& rays, HitBatch& hits) const;
  Status any(const RayBatch& rays, Column<std::uint8_t>& occluded) const;
  Status count(const RayBatch& rays, Crossings crossings, Column<std::uint64_t>& totals) const;
  Status all(const RayBatch& rays, const HitListQuestion& question, HitLists& lists,
             Column<std::uint64_t>& totals) const;

 private:
  /// Calls ask(rays of the group, numbers of these rays, options of the group) for each group.
  template <class Ask>
  Status for_each(const RayBatch& rays, const Ask& ask) const;

  const Engine& engine_;
  const Scene& scene_;
  const Deadline& deadline_;
  const RayOptions& options_;
};

}  // namespace sightline

// Tests: tests/integration/ray_filters_test.py
