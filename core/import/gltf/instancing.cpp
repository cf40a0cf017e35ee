#include "core/import/gltf/instancing.h"

#include <array>

#include "core/import/gltf/transform.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

constexpr std::array<const char*, 3> kNames = {"TRANSLATION", "ROTATION", "SCALE"};
enum Attribute : std::size_t { kTranslation, kRotation, kScale };

struct Attributes {
  std::array<std::optional<AccessorView>, 3> views;
  std::uint64_t count = 0;
};

bool fits(const AccessorView& view, std::size_t attribute) {
  if (view.components != (attribute == kRotation ? 4u : 3u)) return false;
  if (view.component == Component::kF32) return true;
  return attribute == kRotation && view.normalized &&
         (view.component == Component::kI8 || view.component == Component::kI16);
}

Result<Attributes> find_attributes(const GltfDocument& document, std::size_t node,
                                   AccessorReader& accessors) {
  const std::string place = "/nodes/" + std::to_string(node) + "/extensions/" + kInstancing;
  const auto wrong = [&](const std::string& what) {
    return invalid("GLTF_INSTANCING_INVALID", "node " + std::to_string(node) + ": " + what, place);
  };
  const auto& listed = document.model.nodes[node].extensions.at(kInstancing).Get("attributes");
  Attributes attributes;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (!listed.Has(kNames[i])) continue;
    const auto accessor = static_cast<std::size_t>(listed.Get(kNames[i]).GetNumberAsInt());
    auto view = accessors.view(accessor);
    if (!view) return view.error();
    if (!fits(*view, i)) {
      return wrong(std::string("instancing ") + kNames[i] + " is accessor " +
                   std::to_string(accessor) + ", whose type does not fit");
    }
    if (attributes.count != 0 && view->count != attributes.count) {
      return wrong(std::string("instancing ") + kNames[i] + " has " + std::to_string(view->count) +
                   " elements, another attribute has " + std::to_string(attributes.count));
    }
    attributes.count = view->count;
    attributes.views[i] = *view;
  }
  if (attributes.count == 0) return wrong("instancing without TRANSLATION, ROTATION or SCALE");
  return attributes;
}

}  // namespace

Result<std::optional<std::vector<Affine>>> read_placements(const GltfDocument& document,
                                                           std::size_t node,
                                                           AccessorReader& accessors,
                                                           std::uint64_t room) {
  using Placements = std::optional<std::vector<Affine>>;
  if (document.model.nodes[node].extensions.count(kInstancing) == 0) return Placements();
  auto attributes = find_attributes(document, node, accessors);
  if (!attributes) return attributes.error();
  const std::string place = "/nodes/" + std::to_string(node);
  if (attributes->count > room) {
    return beyond_limit("INSTANCES", "node " + std::to_string(node) + ": instances",
                        attributes->count, room, place);
  }
  for (const auto& view : attributes->views) {
    if (view.has_value()) accessors.announce(*view, 0, view->count, &TouchedBytes::placements);
  }

  std::vector<Affine> placements;
  placements.reserve(attributes->count);
  const auto load = [&](std::size_t attribute, std::uint64_t i, std::uint32_t n, double* out) {
    if (attributes->views[attribute].has_value()) {
      load_element(*attributes->views[attribute], i, n, out);
    }
  };
  for (std::uint64_t i = 0; i < attributes->count; ++i) {
    double t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    load(kTranslation, i, 3, t);
    load(kRotation, i, 4, q);
    load(kScale, i, 3, s);
    const bool turned = q[0] != 0 || q[1] != 0 || q[2] != 0 || q[3] != 0;
    placements.push_back(
        from_trs({t[0], t[1], t[2]}, {q[0], q[1], q[2], q[3]}, {s[0], s[1], s[2]}));
    if (!turned || !is_in_range(placements.back())) {
      return invalid("GLTF_TRANSFORM_INVALID",
                     "node " + std::to_string(node) + ", instance " + std::to_string(i) +
                         (turned ? ": its transform is not finite" : ": its rotation is zero"),
                     place);
    }
  }
  return Placements(std::move(placements));
}

}  // namespace sightline::gltf
