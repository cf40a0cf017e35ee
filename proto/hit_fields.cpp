#include "proto/hit_fields.h"

namespace sightline {

std::optional<HitField> find_hit_field(std::string_view name) {
  for (const HitFieldRow& row : kHitFields) {
    if (row.name == name) return row.field;
  }
  return std::nullopt;
}

}  // namespace sightline
