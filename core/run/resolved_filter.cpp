#include "core/run/resolved_filter.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include "core/run/chosen_nodes.h"

namespace sightline {

namespace {

std::uint8_t sides_of(Culling culling, const SceneDescription& scene, std::uint32_t material) {
  switch (culling) {
    case Culling::kNothing:
      return ResolvedFilter::kAll;
    case Culling::kBack:
      return ResolvedFilter::kFront;
    case Culling::kFront:
      return ResolvedFilter::kBack;
    case Culling::kMaterial:
      return material < scene.materials.size() && scene.materials[material].double_sided
                 ? ResolvedFilter::kAll
                 : ResolvedFilter::kFront;
  }
  return ResolvedFilter::kAll;
}

/// What sides(instance, primitive) says of each.
template <class Sides>
Result<ResolvedFilter> sides_where(const Scene& scene, DeadlineWatch& watch, const Sides& sides) {
  const SceneDescription& description = scene.description();
  ResolvedFilter resolved;
  resolved.first.reserve(description.instances.size());
  resolved.sides.reserve(scene.instanced_primitive_count());
  for (const Instance& instance : description.instances) {
    resolved.first.push_back(resolved.sides.size());
    const auto& primitives = description.meshes[instance.mesh]->primitives;
    for (const Primitive& primitive : primitives)
      resolved.sides.push_back(sides(instance, primitive));
    if (watch.passed(1 + primitives.size())) return watch.error();
  }
  return resolved;
}

/// Excludes primitives without a triangle of `only`, so that traversals leave them early.
void leave_primitives_of(const Scene& scene, ResolvedFilter& resolved) {
  Column<std::uint8_t> sides(resolved.sides.size(), 0);
  for (const TriangleId id : *resolved.only) {
    const std::size_t at = resolved.first[id.instance] + scene.primitive_of(id);
    sides[at] = resolved.sides[at];
  }
  resolved.sides = std::move(sides);
}

Result<ResolvedFilter> resolve_watched(const Scene& scene, const HitFilter& filter,
                                       DeadlineWatch& watch, const ReserveBytes& reserve,
                                       SelectionWarnings* warnings) {
  const SceneDescription& description = scene.description();
  std::uint64_t bytes = resolved_filter_bytes(scene);
  for (const auto* choice : {&filter.include, &filter.exclude})
    if (*choice) bytes += choosing_bytes(description, **choice);
  if (Status status = ask_for(reserve, bytes); !status) return std::move(status).error();
  ChosenNodes include, exclude;
  for (const auto& [choice, chosen, key] : {std::tuple{&filter.include, &include, "include"},
                                            std::tuple{&filter.exclude, &exclude, "exclude"}}) {
    if (!*choice) continue;
    auto found = choose(scene, **choice, key, watch, warnings);
    if (!found) return std::move(found).error();
    *chosen = std::move(*found);
  }
  // An exclusion of single triangles does not exclude their primitives.
  const bool excludes = filter.exclude && !exclude.triangles;
  auto resolved =
      sides_where(scene, watch, [&](const Instance& instance, const Primitive& primitive) {
        const bool counts = (instance.mask & filter.mask) != 0 &&
                            (!filter.include || include.holds(instance, primitive.material)) &&
                            !(excludes && exclude.holds(instance, primitive.material));
        return counts ? sides_of(filter.culling, description, primitive.material) : std::uint8_t{0};
      });
  if (!resolved) return resolved;
  resolved->only = std::move(include.triangles);
  if (exclude.triangles) resolved->without = std::move(*exclude.triangles);
  if (resolved->only) leave_primitives_of(scene, *resolved);
  return resolved;
}

/// Without masks to compare: the explanation of a ray need not know of them.
Result<std::optional<ResolvedFilter>> resolve_for_ray(const Scene& scene, const HitFilter& filter,
                                                      std::uint32_t mask, DeadlineWatch& watch,
                                                      const ReserveBytes& reserve,
                                                      SelectionWarnings* warnings) {
  auto resolved = resolve_watched(scene, filter, watch, reserve, warnings);
  if (!resolved) return std::move(resolved).error();
  const auto& instances = scene.description().instances;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (watch.passed()) return watch.error();
    if ((instances[i].mask & mask) != 0) continue;
    const std::size_t end =
        i + 1 < instances.size() ? resolved->first[i + 1] : resolved->sides.size();
    std::fill(resolved->sides.begin() + static_cast<std::ptrdiff_t>(resolved->first[i]),
              resolved->sides.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{0});
  }
  return std::optional<ResolvedFilter>(std::move(*resolved));
}

/// Whether every ray meets every instance, as far as their masks go; false also where there are so
/// many different masks that to compare them costs more than it saves.
Result<bool> all_meet(const Scene& scene, std::span<const std::uint32_t> ray_masks,
                      DeadlineWatch& watch) {
  constexpr std::size_t kMostMasks = 64;
  std::vector<std::uint32_t> different;
  for (const Instance& instance : scene.description().instances) {
    if (watch.passed()) return watch.error();
    if (!different.empty() && different.back() == instance.mask) continue;
    if (std::find(different.begin(), different.end(), instance.mask) == different.end())
      different.push_back(instance.mask);
    if (different.size() > kMostMasks) return false;
  }
  for (std::size_t i = 0; i < ray_masks.size(); ++i) {
    if (watch.passed()) return watch.error();
    if (i > 0 && ray_masks[i] == ray_masks[i - 1]) continue;
    for (const std::uint32_t mask : different)
      if ((mask & ray_masks[i]) == 0) return false;
  }
  return true;
}

}  // namespace

std::uint64_t resolved_filter_bytes(const Scene& scene) {
  return scene.description().instances.size() * (sizeof(std::size_t) + sizeof(std::uint32_t)) +
         scene.instanced_primitive_count();
}

Result<ResolvedFilter> resolve_filter(const Scene& scene, const HitFilter& filter,
                                      const Deadline& deadline, const ReserveBytes& reserve,
                                      SelectionWarnings* warnings) {
  DeadlineWatch watch(deadline);
  return resolve_watched(scene, filter, watch, reserve, warnings);
}

Result<ResolvedFilter> chosen_sides(const Scene& scene, const TriangleChoice& choice,
                                    const std::string& key, const Deadline& deadline,
                                    const ReserveBytes& reserve, SelectionWarnings* warnings) {
  const std::uint64_t bytes =
      resolved_filter_bytes(scene) + choosing_bytes(scene.description(), choice);
  if (Status status = ask_for(reserve, bytes); !status) return std::move(status).error();
  DeadlineWatch watch(deadline);
  const auto chosen = choose(scene, choice, key, watch, warnings);
  if (!chosen) return chosen.error();
  return sides_where(scene, watch, [&](const Instance& instance, const Primitive& primitive) {
    return chosen->holds(instance, primitive.material) ? ResolvedFilter::kAll : std::uint8_t{0};
  });
}

Result<std::optional<ResolvedFilter>> resolve_for_rays(const Scene& scene, const HitFilter& filter,
                                                       std::span<const std::uint32_t> ray_masks,
                                                       const Deadline& deadline,
                                                       const ReserveBytes& reserve,
                                                       SelectionWarnings* warnings) {
  using Resolved = std::optional<ResolvedFilter>;
  if (filter.accepts_all() && ray_masks.empty() && !scene.has_empty_mask()) return Resolved();
  DeadlineWatch watch(deadline);
  if (ray_masks.size() == 1 && ray_masks[0] != 0xffffffffu)
    return resolve_for_ray(scene, filter, ray_masks[0], watch, reserve, warnings);
  bool has_masks = false;
  if (!ray_masks.empty()) {
    const auto found = all_meet(scene, ray_masks, watch);
    if (!found) return found.error();
    has_masks = !*found;
  }
  if (filter.accepts_all() && !has_masks && !scene.has_empty_mask()) return Resolved();
  auto resolved = resolve_watched(scene, filter, watch, reserve, warnings);
  if (!resolved) return std::move(resolved).error();
  if (has_masks) {
    resolved->masks.reserve(scene.description().instances.size());
    for (const Instance& instance : scene.description().instances)
      resolved->masks.push_back(instance.mask);
  }
  const bool all = resolved->masks.empty() && !resolved->names_triangles() &&
                   std::all_of(resolved->sides.begin(), resolved->sides.end(),
                               [](std::uint8_t sides) { return sides == ResolvedFilter::kAll; });
  return all ? Resolved() : Resolved(std::move(*resolved));
}

std::vector<bool> counting_primitives(const Scene& scene, std::size_t instance,
                                      const ResolvedFilter* resolved) {
  const SceneDescription& description = scene.description();
  std::vector<bool> counts(
      description.meshes[description.instances[instance].mesh]->primitives.size(), true);
  for (std::size_t p = 0; resolved != nullptr && p < counts.size(); ++p)
    counts[p] = resolved->sides[resolved->first[instance] + p] != 0;
  return counts;
}

bool select_alike(const ResolvedFilter& a, const ResolvedFilter& b) {
  return std::equal(a.sides.begin(), a.sides.end(), b.sides.begin(), b.sides.end());
}

}  // namespace sightline
