#pragma once
/// The fields of a hit, from the table in proto/hit_fields.def, and sets of them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <string_view>

namespace sightline {

/// The type of a field's values; hit_fields.def explains them.
enum class FieldKind : std::uint8_t { kNumber, kIndex, kId, kVector, kFlag, kText, kNamed };
/// What a value is computed from: the ray and its hit, the traversal of the ray, the scene, a
/// HitDetail, or vertex attributes.
enum class FieldSource : std::uint8_t { kRay, kCost, kScene, kDetail, kAttribute };

/// The fields, in the order in which answers write them.
enum class HitField : std::uint8_t {
#define HIT_FIELD(field, name, kind, width, source, doc) field,
#include "proto/hit_fields.def"
#undef HIT_FIELD
};

/// A row of the table.
struct HitFieldRow {
  HitField field;
  std::string_view name;
  FieldKind kind;
  std::size_t width;  ///< number of numbers in a value
  FieldSource source;
};
/// The table, in the order of HitField.
inline constexpr HitFieldRow kHitFields[] = {
#define HIT_FIELD(field, name, kind, width, source, doc) \
  {HitField::field, name, FieldKind::kind, width, FieldSource::source},
#include "proto/hit_fields.def"
#undef HIT_FIELD
};
/// The number of fields.
inline constexpr std::size_t kHitFieldCount = std::size(kHitFields);
static_assert(kHitFieldCount <= 32, "FieldSet has 32 bits");

/// The row of a field in the table.
constexpr const HitFieldRow& hit_field_row(HitField field) {
  return kHitFields[static_cast<std::size_t>(field)];
}
constexpr std::string_view hit_field_name(HitField field) { return hit_field_row(field).name; }
/// The number of numbers in a value: 3 for a vector.
constexpr std::size_t hit_field_width(HitField field) { return hit_field_row(field).width; }
/// Finds a field by its name; empty if there is none.
std::optional<HitField> find_hit_field(std::string_view name);
/// All fields, in their order.
constexpr auto all_hit_fields() {
  std::array<HitField, kHitFieldCount> fields{};
  for (std::size_t i = 0; i < fields.size(); ++i) fields[i] = kHitFields[i].field;
  return fields;
}

/// A set of fields.
class FieldSet {
 public:
  constexpr FieldSet() = default;
  constexpr FieldSet(std::initializer_list<HitField> fields) {
    for (const HitField field : fields) add(field);
  }
  constexpr void add(HitField field) { bits_ |= bit(field); }
  constexpr void remove(HitField field) { bits_ &= ~bit(field); }
  constexpr bool has(HitField field) const { return (bits_ & bit(field)) != 0; }
  constexpr bool has_any_of(FieldSet other) const { return (bits_ & other.bits_) != 0; }
  constexpr bool empty() const { return bits_ == 0; }
  bool operator==(const FieldSet&) const = default;

 private:
  static constexpr std::uint32_t bit(HitField field) {
    return std::uint32_t{1} << static_cast<unsigned>(field);
  }
  std::uint32_t bits_ = 0;
};

/// The most numbers of one hit with these fields, `named` of which the file names.
constexpr std::size_t numbers_of(FieldSet fields, std::size_t named) {
  std::size_t numbers = 0;
  for (const HitFieldRow& row : kHitFields) {
    if (fields.has(row.field)) numbers += row.width * (row.kind == FieldKind::kNamed ? named : 1);
  }
  return numbers;
}

/// The fields for whose rows is_chosen(row) returns true.
template <class Chooses>
constexpr FieldSet fields_where(Chooses is_chosen) {
  FieldSet fields;
  for (const HitFieldRow& row : kHitFields) {
    if (is_chosen(row)) fields.add(row.field);
  }
  return fields;
}
/// All fields of the table.
inline constexpr FieldSet kAllHitFields = fields_where([](const HitFieldRow&) { return true; });
/// The fields of a request that does not choose any.
inline constexpr FieldSet kDefaultHitFields{
    HitField::kT,        HitField::kInstance, HitField::kPrimitive, HitField::kTriangle,
    HitField::kPosition, HitField::kNormal,   HitField::kNode,      HitField::kMesh};
/// Fields that read vertex attributes of the file.
inline constexpr FieldSet kAttributeFields =
    fields_where([](const HitFieldRow& row) { return row.source == FieldSource::kAttribute; });
/// Fields that need a HitDetail for each hit.
inline constexpr FieldSet kDetailFields = fields_where([](const HitFieldRow& row) {
  return row.source == FieldSource::kDetail || row.source == FieldSource::kAttribute;
});
/// Fields of the cost of a ray (Engine::costs).
inline constexpr FieldSet kCostFields =
    fields_where([](const HitFieldRow& row) { return row.source == FieldSource::kCost; });
/// Fields of text, which binary answers cannot have.
inline constexpr FieldSet kTextFields =
    fields_where([](const HitFieldRow& row) { return row.kind == FieldKind::kText; });

}  // namespace sightline

// Tests: tests/unit/proto/hit_json_test.cpp
