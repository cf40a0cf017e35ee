#include "core/run/kept_sides.h"

#include <algorithm>
#include <set>
#include <unordered_set>

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

bool matches_any(const std::vector<std::string>& patterns, const std::string& name) {
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](const std::string& pattern) { return glob_matches(pattern, name); });
}

Result<Chosen> choose(const SceneDescription& scene, const TriangleChoice& choice,
                      const std::string& key) {
  Chosen chosen;
  chosen.node.assign(scene.nodes.size(), choice.nodes || choice.names ? 0 : 1);
  if (choice.nodes) {
    // Of those that are asked for, not of all that there are: a scene may have a million.
    std::unordered_set<std::uint32_t> asked(choice.nodes->begin(), choice.nodes->end());
    std::unordered_set<std::uint32_t> found;
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
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
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    // Parents stand before their children.
    const Node& node = scene.nodes[i];
    if ((choice.names && matches_any(*choice.names, node.name)) ||
        (node.parent != kNone && chosen.node[node.parent] != 0)) {
      chosen.node[i] = 1;
    }
  }
  chosen.material.assign(scene.materials.size() + 1, choice.materials ? 0 : 1);
  for (std::size_t i = 0; choice.materials && i < scene.materials.size(); ++i) {
    chosen.material[i] = matches_any(*choice.materials, scene.materials[i].name) ? 1 : 0;
  }
  return chosen;
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
KeptSides sides_where(const SceneDescription& scene, const Sides& sides) {
  KeptSides kept;
  kept.first.reserve(scene.instances.size());
  for (const Instance& instance : scene.instances) {
    kept.first.push_back(kept.sides.size());
    for (const Primitive& primitive : scene.meshes[instance.mesh]->primitives)
      kept.sides.push_back(sides(instance, primitive));
  }
  return kept;
}

}  // namespace

Result<KeptSides> kept_sides(const Scene& scene, const HitFilter& filter) {
  const SceneDescription& description = scene.description();
  Chosen include, exclude;
  for (const auto& [choice, chosen, key] : {std::tuple{&filter.include, &include, "include"},
                                            std::tuple{&filter.exclude, &exclude, "exclude"}}) {
    if (!*choice) continue;
    auto found = choose(description, **choice, key);
    if (!found) return std::move(found).error();
    *chosen = std::move(*found);
  }
  return sides_where(description, [&](const Instance& instance, const Primitive& primitive) {
    const bool counts = (instance.mask & filter.mask) != 0 &&
                        (!filter.include || include.holds(instance, primitive.material)) &&
                        !(filter.exclude && exclude.holds(instance, primitive.material));
    return counts ? sides_of(filter.culling, description, primitive.material) : std::uint8_t{0};
  });
}

Result<KeptSides> chosen_sides(const Scene& scene, const TriangleChoice& choice,
                               const std::string& key) {
  const auto chosen = choose(scene.description(), choice, key);
  if (!chosen) return chosen.error();
  return sides_where(
      scene.description(), [&](const Instance& instance, const Primitive& primitive) {
        return chosen->holds(instance, primitive.material) ? KeptSides::kAll : std::uint8_t{0};
      });
}

namespace {

/// Without masks to compare: whoever explains a ray need not know of them.
Result<std::optional<KeptSides>> kept_for_ray(const Scene& scene, const HitFilter& filter,
                                              std::uint32_t mask) {
  auto kept = kept_sides(scene, filter);
  if (!kept) return std::move(kept).error();
  const auto& instances = scene.description().instances;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if ((instances[i].mask & mask) != 0) continue;
    const std::size_t end = i + 1 < instances.size() ? kept->first[i + 1] : kept->sides.size();
    std::fill(kept->sides.begin() + static_cast<std::ptrdiff_t>(kept->first[i]),
              kept->sides.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{0});
  }
  return std::optional<KeptSides>(std::move(*kept));
}

}  // namespace

Result<std::optional<KeptSides>> kept_for_rays(const Scene& scene, const HitFilter& filter,
                                               std::span<const std::uint32_t> ray_masks) {
  using Kept = std::optional<KeptSides>;
  Column<std::uint32_t> masks;
  if (ray_masks.size() == 1 && ray_masks[0] != 0xffffffffu)
    return kept_for_ray(scene, filter, ray_masks[0]);
  if (!ray_masks.empty()) {
    std::set<std::uint32_t> different;
    for (const Instance& instance : scene.description().instances) {
      masks.push_back(instance.mask);
      different.insert(instance.mask);
    }
    const bool all_meet = std::all_of(different.begin(), different.end(), [&](std::uint32_t mask) {
      return std::all_of(ray_masks.begin(), ray_masks.end(),
                         [&](std::uint32_t ray) { return (mask & ray) != 0; });
    });
    if (all_meet) masks = {};
  }
  if (filter.keeps_all() && masks.empty() && !scene.has_empty_mask()) return Kept();
  auto kept = kept_sides(scene, filter);
  if (!kept) return std::move(kept).error();
  kept->masks = std::move(masks);
  const bool all = kept->masks.empty() &&
                   std::all_of(kept->sides.begin(), kept->sides.end(),
                               [](std::uint8_t sides) { return sides == KeptSides::kAll; });
  return all ? Kept() : Kept(std::move(*kept));
}

}  // namespace sightline
