#include "core/import/gltf/alpha_materials.h"

#include <string>

#include "core/import/input/refusal.h"

namespace sightline::gltf {
namespace {

/// The number of placed triangles of each material.
std::vector<std::uint64_t> placed_triangles(const SceneDescription& scene) {
  std::vector<std::uint64_t> placements(scene.meshes.size()), triangles(scene.materials.size());
  for (const Instance& each : scene.instances) ++placements[each.mesh];
  for (std::size_t mesh = 0; mesh < scene.meshes.size(); ++mesh) {
    for (const Primitive& part : scene.meshes[mesh]->primitives) {
      if (part.material < triangles.size())
        triangles[part.material] += placements[mesh] * part.triangle_count;
    }
  }
  return triangles;
}

std::string counted(std::uint64_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

template <class IsKind>
void add_warning(const std::string& kind, const IsKind& is_kind,
                 const std::vector<std::uint64_t>& triangles, SceneDescription& scene) {
  constexpr std::uint64_t kMostNames = 5;
  std::uint64_t materials = 0, total = 0;
  std::string names;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const Material& material = scene.materials[i];
    if (triangles[i] == 0 || !is_kind(material)) continue;
    total += triangles[i];
    if (++materials > kMostNames) continue;
    names += (names.empty() ? "" : ", ") + (material.name.empty()
                                                ? "material " + std::to_string(i)
                                                : "\"" + shortened(material.name) + "\"");
  }
  if (materials == 0) return;
  if (materials > kMostNames) names += " and " + std::to_string(materials - kMostNames) + " more";
  scene.warnings.push_back(kind + ": rays hit " + counted(total, "triangle") + " of " +
                           counted(materials, "material") + " as if opaque: " + names);
}

}  // namespace

void add_alpha_warnings(SceneDescription& scene) {
  const std::vector<std::uint64_t> triangles = placed_triangles(scene);
  for (const AlphaMode mode : {AlphaMode::kMask, AlphaMode::kBlend}) {
    const auto has_mode = [mode](const Material& each) { return each.alpha_mode == mode; };
    add_warning(std::string("alphaMode ") + alpha_mode_name(mode), has_mode, triangles, scene);
  }
  const auto only_transmits = [](const Material& each) {
    return each.transmits && each.alpha_mode == AlphaMode::kOpaque;
  };
  add_warning("KHR_materials_transmission", only_transmits, triangles, scene);
}

}  // namespace sightline::gltf
