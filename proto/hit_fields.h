#pragma once
/// The fields of a hit: their names in "fields" and in the answer.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sightline {

/// In the order in which an answer writes them.
enum class HitField : std::uint8_t {
  kT,              ///< number; counts in |direction|
  kDistance,       ///< number; counts in scene units
  kInstance,       ///< placement of a mesh, in file order
  kPrimitive,      ///< index in the file's mesh
  kTriangle,       ///< index in the primitive, strips and fans unrolled
  kPosition,       ///< [x, y, z], world
  kNormal,         ///< [x, y, z], geometric, unit, world
  kShadingNormal,  ///< [x, y, z], of the file's normals, unit, world; null when it gives none
  kBarycentrics,   ///< [u, v], the weights of the second and third corner
  kUv,             ///< [u, v], of the file's TEXCOORD_0; null when it gives none
  kColour,         ///< [r, g, b, a], of the file's COLOR_0; null when it gives none
  kFront,          ///< whether the ray meets the counter-clockwise side
  kOnEdge,         ///< whether it meets an edge or a corner, exactly
  kNode,           ///< name, null when the file gives none
  kNodeId,         ///< index in the file's "nodes"
  kNodePath,       ///< names from the root down: "/house/roof"
  kMesh,           ///< name, null when the file gives none
  kMeshId,         ///< index in the file's "meshes"
  kMaterial,       ///< name, null when the file gives none
  kMaterialId,     ///< index in the file's "materials"
};
inline constexpr std::size_t kHitFieldCount = 20;

std::string_view hit_field_name(HitField field);
/// Numbers in one value: a vector has three.
std::size_t hit_field_width(HitField field);
std::optional<HitField> find_hit_field(std::string_view name);
/// All fields in their order.
std::span<const HitField> all_hit_fields();

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

inline constexpr FieldSet kAllHitFields = [] {
  FieldSet fields;
  for (std::size_t i = 0; i < kHitFieldCount; ++i) fields.add(static_cast<HitField>(i));
  return fields;
}();
/// The fields of a request without "fields".
inline constexpr FieldSet kDefaultHitFields{
    HitField::kT,        HitField::kInstance, HitField::kPrimitive, HitField::kTriangle,
    HitField::kPosition, HitField::kNormal,   HitField::kNode,      HitField::kMesh};
/// Fields that need a HitDetail of each hit.
inline constexpr FieldSet kDetailFields{
    HitField::kPosition, HitField::kNormal, HitField::kShadingNormal, HitField::kBarycentrics,
    HitField::kUv,       HitField::kColour, HitField::kFront,         HitField::kOnEdge};
/// Fields that read vertex attributes of the file.
inline constexpr FieldSet kAttributeFields{HitField::kShadingNormal, HitField::kUv,
                                           HitField::kColour};

}  // namespace sightline
