#include "core/run/grouped_rays.h"

#include <string>

#include "core/run/unbuilt_rounds.h"

namespace sightline {
namespace {

/// The text that a pointer into filter `number` begins with.
std::string filter_place(std::size_t number) { return "/filters/list/" + std::to_string(number); }

}  // namespace

Result<std::vector<FilteredRays>> group_rays(const Scene& scene, const RayBatch& rays,
                                             std::span<const HitFilter> filters,
                                             std::span<const std::uint32_t> filter_of,
                                             const Deadline& deadline, const ReserveBytes& reserve,
                                             SelectionWarnings* warnings) {
  std::vector<FilteredRays> groups(filters.size());
  for (std::size_t i = 0; i < filter_of.size(); ++i) groups[filter_of[i]].numbers.push_back(i);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    Column<std::uint32_t> masks;
    if (!rays.mask.empty()) {
      for (const std::size_t i : groups[k].numbers) masks.push_back(rays.mask[i]);
    }
    const std::size_t earlier = warnings == nullptr ? 0 : warnings->size();
    auto resolved = resolve_for_rays(scene, filters[k], masks, deadline, reserve, warnings);
    if (!resolved) {
      Error error = std::move(resolved).error();
      if (!error.pointer.empty()) error.pointer = filter_place(k) + error.pointer;
      return error;
    }
    groups[k].resolved = std::move(*resolved);
    for (std::size_t i = earlier; warnings != nullptr && i < warnings->size(); ++i)
      (*warnings)[i].pointer = filter_place(k) + (*warnings)[i].pointer;
  }
  return groups;
}

template <class Ask>
Status GroupedRays::for_each(const RayBatch& rays, const Ask& ask) const {
  RayOptions options = options_;
  options.groups = {};
  for (const FilteredRays& group : options_.groups) {
    if (group.numbers.empty()) continue;
    options.resolved = group.resolved ? &*group.resolved : nullptr;
    if (Status status = ask(rays_of(rays, group.numbers), group.numbers, options); !status)
      return status;
  }
  return success();
}

Status GroupedRays::closest(const RayBatch& rays, HitBatch& hits) const {
  hits.resize(rays.size());
  HitBatch found;
  return for_each(
      rays, [&](const RayBatch& some, const Column<std::size_t>& numbers, const RayOptions& each) {
        Status status = engine_.closest(scene_, some, deadline_, found, each);
        for (std::size_t k = 0; status && k < numbers.size(); ++k) {
          hits.copy(found, k, numbers[k]);
        }
        return status;
      });
}

Status GroupedRays::any(const RayBatch& rays, Column<std::uint8_t>& occluded) const {
  occluded.resize(rays.size());
  Column<std::uint8_t> found;
  return for_each(
      rays, [&](const RayBatch& some, const Column<std::size_t>& numbers, const RayOptions& each) {
        Status status = engine_.any(scene_, some, deadline_, found, each);
        for (std::size_t k = 0; status && k < numbers.size(); ++k) occluded[numbers[k]] = found[k];
        return status;
      });
}

Status GroupedRays::count(const RayBatch& rays, Crossings crossings,
                          Column<std::uint64_t>& totals) const {
  totals.resize(rays.size());
  Column<std::uint64_t> found;
  return for_each(
      rays, [&](const RayBatch& some, const Column<std::size_t>& numbers, const RayOptions& each) {
        Status status = engine_.count(scene_, some, crossings, deadline_, found, each);
        for (std::size_t k = 0; status && k < numbers.size(); ++k) totals[numbers[k]] = found[k];
        return status;
      });
}

Status GroupedRays::all(const RayBatch& rays, const HitListQuestion& question, HitLists& lists,
                        Column<std::uint64_t>& totals) const {
  /// Where the list of a ray begins and ends in the hits of all groups.
  struct Part {
    std::size_t begin = 0, end = 0;
  };
  totals.resize(rays.size());
  std::vector<Part> parts(rays.size());
  HitBatch gathered;
  HitListQuestion rest = question;
  Column<std::uint64_t> found;
  Status status = for_each(
      rays, [&](const RayBatch& some, const Column<std::size_t>& numbers, const RayOptions& each) {
        HitLists some_lists;
        Status asked = engine_.all(scene_, some, rest, deadline_, some_lists, found, each);
        if (!asked) return asked;
        const std::size_t before = gathered.size();
        gathered.append(some_lists.hits);
        rest.total_max -= some_lists.hits.size();
        for (std::size_t k = 0; k < numbers.size(); ++k) {
          totals[numbers[k]] = found[k];
          parts[numbers[k]] = {before + some_lists.first[k], before + some_lists.first[k + 1]};
        }
        return asked;
      });
  if (!status) return status;
  lists.first.assign(1, 0);
  lists.hits.resize(gathered.size());
  std::size_t slot = 0;
  for (const Part& part : parts) {
    for (std::size_t i = part.begin; i < part.end; ++i, ++slot) {
      lists.hits.copy(gathered, i, slot);
    }
    lists.first.push_back(slot);
  }
  return status;
}

}  // namespace sightline
