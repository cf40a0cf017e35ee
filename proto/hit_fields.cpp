#include "proto/hit_fields.h"

#include <array>

namespace sightline {
namespace {

constexpr std::array<std::string_view, kHitFieldCount> kNames{
    "t",         "distance", "instance",       "primitive",    "triangle",
    "position",  "normal",   "shading_normal", "barycentrics", "uv",
    "colour",    "front",    "on_edge",        "node",         "node_id",
    "node_path", "mesh",     "mesh_id",        "material",     "material_id"};

constexpr auto kAll = [] {
  std::array<HitField, kHitFieldCount> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<HitField>(i);
  return all;
}();

}  // namespace

std::string_view hit_field_name(HitField field) { return kNames[static_cast<std::size_t>(field)]; }

std::size_t hit_field_width(HitField field) {
  switch (field) {
    case HitField::kColour:
      return 4;
    case HitField::kPosition:
    case HitField::kNormal:
    case HitField::kShadingNormal:
      return 3;
    case HitField::kBarycentrics:
    case HitField::kUv:
      return 2;
    default:
      return 1;
  }
}

std::optional<HitField> find_hit_field(std::string_view name) {
  for (const HitField field : kAll) {
    if (hit_field_name(field) == name) return field;
  }
  return std::nullopt;
}

std::span<const HitField> all_hit_fields() { return kAll; }

}  // namespace sightline
