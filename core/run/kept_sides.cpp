#include "core/run/kept_sides.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <string_view>
#include <tuple>
#include <unordered_set>
#include <vector>

namespace sightline {

namespace {

/// Which nodes and materials a choice names.
struct Chosen {
  Column<std::uint8_t> node;      ///< 1 or 0, by SceneDescription::nodes
  Column<std::uint8_t> material;  ///< by SceneDescription::materials; the last one: no material

  bool holds(const Instance& instance, std::uint32_t its_material) const {
    const std::size_t none = material.size() - 1;
    return node[instance.node] != 0 && material[std::min<std::size_t>(its_material, none)] != 0;
  }
};

/// Whether any of the patterns matches a text. Of texts that come again what was found is
/// remembered: a scene may have a hundred thousand nodes of one name.
class AnyGlob {
 public:
  AnyGlob(const std::vector<std::string>& patterns, std::size_t texts, DeadlineWatch& watch)
      : patterns_(patterns), watch_(watch), known_(slots_for(texts)) {}

  /// False also where the watch has passed.
  bool matches(std::string_view text) {
    const std::size_t hash = std::hash<std::string_view>()(text);
    // What takes the same slot takes its place: the table is bounded, and most names are few.
    Known& known = known_[hash & (known_.size() - 1)];
    if (!known.is_set || known.hash != hash || known.text != text) {
      const bool is_match = std::any_of(
          patterns_.begin(), patterns_.end(),
          [&](const std::string& pattern) { return glob_matches(pattern, text, watch_); });
      known = {text, hash, is_match, true};
    }
    // To hash and to compare read sixteen bytes and more in the time of a step.
    watch_.passed(1 + text.size() / 16);
    return known.is_match;
  }
  static std::uint64_t bytes_for(std::size_t texts) { return slots_for(texts) * sizeof(Known); }

 private:
  struct Known {
    std::string_view text = {};
    std::size_t hash = 0;
    bool is_match = false, is_set = false;
  };
  static std::size_t slots_for(std::size_t texts) {
    constexpr std::size_t kMost = 32 << 10;
    return std::bit_ceil(std::clamp<std::size_t>(2 * std::min(texts, kMost), 1, kMost));
  }

  const std::vector<std::string>& patterns_;
  DeadlineWatch& watch_;
  std::vector<Known> known_;
};

Result<Chosen> choose(const SceneDescription& scene, const TriangleChoice& choice,
                      const std::string& key, DeadlineWatch& watch) {
  Chosen chosen;
  chosen.node.assign(scene.nodes.size(), choice.nodes || choice.names ? 0 : 1);
  if (choice.nodes) {
    // Of those that are asked for, not of all that there are: a scene may have a million.
    std::unordered_set<std::uint32_t> asked(choice.nodes->begin(), choice.nodes->end());
    std::unordered_set<std::uint32_t> found;
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
      if (watch.passed()) return watch.error();
      if (!asked.contains(scene.nodes[i].file_node)) continue;
      chosen.node[i] = 1;
      found.insert(scene.nodes[i].file_node);
    }
    for (std::size_t i = 0; i < choice.nodes->size(); ++i) {
      if (found.contains((*choice.nodes)[i])) continue;
      return Error{ErrorKind::kInvalid, "FILTER_NODE_UNKNOWN",
                   "the loaded scene has no node " + std::to_string((*choice.nodes)[i]),
                   "/" + key + "/nodes/" + std::to_string(i)};
    }
  }
  std::optional<AnyGlob> names, materials;
  if (choice.names) names.emplace(*choice.names, scene.nodes.size(), watch);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    // Parents stand before their children.
    const Node& node = scene.nodes[i];
    if ((node.parent != kNone && chosen.node[node.parent] != 0) ||
        (names && names->matches(node.name))) {
      chosen.node[i] = 1;
    }
    if (watch.passed()) return watch.error();
  }
  names.reset();
  chosen.material.assign(scene.materials.size() + 1, choice.materials ? 0 : 1);
  if (choice.materials) materials.emplace(*choice.materials, scene.materials.size(), watch);
  for (std::size_t i = 0; materials && i < scene.materials.size(); ++i) {
    chosen.material[i] = materials->matches(scene.materials[i].name) ? 1 : 0;
    if (watch.passed()) return watch.error();
  }
  return chosen;
}

/// What choose() takes besides what it returns, and that.
std::uint64_t choosing_bytes(const SceneDescription& scene, const TriangleChoice& choice) {
  constexpr std::uint64_t kAskedBytes = 64;  // in two sets
  std::uint64_t bytes = scene.nodes.size() + scene.materials.size() + 1;
  if (choice.nodes) bytes += choice.nodes->size() * kAskedBytes;
  if (choice.names) bytes += AnyGlob::bytes_for(scene.nodes.size());
  if (choice.materials) bytes += AnyGlob::bytes_for(scene.materials.size());
  return bytes;
}

std::uint8_t sides_of(Culling culling, const SceneDescription& scene, std::uint32_t material) {
  switch (culling) {
    case Culling::kNothing:
      return KeptSides::kAll;
    case Culling::kBack:
      return KeptSides::kFront;
    case Culling::kFront:
      return KeptSides::kBack;
    case Culling::kMaterial:
      return material < scene.materials.size() && scene.materials[material].double_sided
                 ? KeptSides::kAll
                 : KeptSides::kFront;
  }
  return KeptSides::kAll;
}

/// What sides(instance, primitive) says of each.
template <class Sides>
Result<KeptSides> sides_where(const Scene& scene, DeadlineWatch& watch, const Sides& sides) {
  const SceneDescription& description = scene.description();
  KeptSides kept;
  kept.first.reserve(description.instances.size());
  kept.sides.reserve(scene.instanced_primitive_count());
  for (const Instance& instance : description.instances) {
    kept.first.push_back(kept.sides.size());
    const auto& primitives = description.meshes[instance.mesh]->primitives;
    for (const Primitive& primitive : primitives) kept.sides.push_back(sides(instance, primitive));
    if (watch.passed(1 + primitives.size())) return watch.error();
  }
  return kept;
}

Result<KeptSides> kept_sides_watched(const Scene& scene, const HitFilter& filter,
                                     DeadlineWatch& watch, const ReserveBytes& reserve) {
  const SceneDescription& description = scene.description();
  std::uint64_t bytes = kept_sides_bytes(scene);
  for (const auto* choice : {&filter.include, &filter.exclude})
    if (*choice) bytes += choosing_bytes(description, **choice);
  if (Status status = ask_for(reserve, bytes); !status) return std::move(status).error();
  Chosen include, exclude;
  for (const auto& [choice, chosen, key] : {std::tuple{&filter.include, &include, "include"},
                                            std::tuple{&filter.exclude, &exclude, "exclude"}}) {
    if (!*choice) continue;
    auto found = choose(description, **choice, key, watch);
    if (!found) return std::move(found).error();
    *chosen = std::move(*found);
  }
  return sides_where(scene, watch, [&](const Instance& instance, const Primitive& primitive) {
    const bool counts = (instance.mask & filter.mask) != 0 &&
                        (!filter.include || include.holds(instance, primitive.material)) &&
                        !(filter.exclude && exclude.holds(instance, primitive.material));
    return counts ? sides_of(filter.culling, description, primitive.material) : std::uint8_t{0};
  });
}

/// Without masks to compare: whoever explains a ray need not know of them.
Result<std::optional<KeptSides>> kept_for_ray(const Scene& scene, const HitFilter& filter,
                                              std::uint32_t mask, DeadlineWatch& watch,
                                              const ReserveBytes& reserve) {
  auto kept = kept_sides_watched(scene, filter, watch, reserve);
  if (!kept) return std::move(kept).error();
  const auto& instances = scene.description().instances;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (watch.passed()) return watch.error();
    if ((instances[i].mask & mask) != 0) continue;
    const std::size_t end = i + 1 < instances.size() ? kept->first[i + 1] : kept->sides.size();
    std::fill(kept->sides.begin() + static_cast<std::ptrdiff_t>(kept->first[i]),
              kept->sides.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{0});
  }
  return std::optional<KeptSides>(std::move(*kept));
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

std::uint64_t kept_sides_bytes(const Scene& scene) {
  return scene.description().instances.size() * (sizeof(std::size_t) + sizeof(std::uint32_t)) +
         scene.instanced_primitive_count();
}

Result<KeptSides> kept_sides(const Scene& scene, const HitFilter& filter, const Deadline& deadline,
                             const ReserveBytes& reserve) {
  DeadlineWatch watch(deadline);
  return kept_sides_watched(scene, filter, watch, reserve);
}

Result<KeptSides> chosen_sides(const Scene& scene, const TriangleChoice& choice,
                               const std::string& key, const Deadline& deadline,
                               const ReserveBytes& reserve) {
  const std::uint64_t bytes = kept_sides_bytes(scene) + choosing_bytes(scene.description(), choice);
  if (Status status = ask_for(reserve, bytes); !status) return std::move(status).error();
  DeadlineWatch watch(deadline);
  const auto chosen = choose(scene.description(), choice, key, watch);
  if (!chosen) return chosen.error();
  return sides_where(scene, watch, [&](const Instance& instance, const Primitive& primitive) {
    return chosen->holds(instance, primitive.material) ? KeptSides::kAll : std::uint8_t{0};
  });
}

Result<std::optional<KeptSides>> kept_for_rays(const Scene& scene, const HitFilter& filter,
                                               std::span<const std::uint32_t> ray_masks,
                                               const Deadline& deadline,
                                               const ReserveBytes& reserve) {
  using Kept = std::optional<KeptSides>;
  if (filter.keeps_all() && ray_masks.empty() && !scene.has_empty_mask()) return Kept();
  DeadlineWatch watch(deadline);
  if (ray_masks.size() == 1 && ray_masks[0] != 0xffffffffu)
    return kept_for_ray(scene, filter, ray_masks[0], watch, reserve);
  bool has_masks = false;
  if (!ray_masks.empty()) {
    const auto found = all_meet(scene, ray_masks, watch);
    if (!found) return found.error();
    has_masks = !*found;
  }
  if (filter.keeps_all() && !has_masks && !scene.has_empty_mask()) return Kept();
  auto kept = kept_sides_watched(scene, filter, watch, reserve);
  if (!kept) return std::move(kept).error();
  if (has_masks) {
    kept->masks.reserve(scene.description().instances.size());
    for (const Instance& instance : scene.description().instances)
      kept->masks.push_back(instance.mask);
  }
  const bool all = kept->masks.empty() &&
                   std::all_of(kept->sides.begin(), kept->sides.end(),
                               [](std::uint8_t sides) { return sides == KeptSides::kAll; });
  return all ? Kept() : Kept(std::move(*kept));
}

}  // namespace sightline
