#pragma once
/// The values of each field of hits as a column, for all formats of answers. For files of this room
/// only.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "core/query/hit_batch.h"
#include "proto/hit_fields.h"
#include "proto/hit_terms.h"

namespace sightline {

/// The data from which the columns are made; must outlive the columns. `details` and each column of
/// `terms` have a slot for each of `hits`, or are empty if no requested field needs them.
struct HitAnswer {
  const HitBatch& hits;
  std::span<const HitDetail> details;
  const HitTerms& terms;
};

/// The value in a column of numbers if there is none.
inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Each column has kWidth values for each hit.

/// A column of numbers; a number that is not finite means that there is no value.
struct NumberColumn {
  static constexpr std::size_t kWidth = 1;
  std::span<const double> numbers;
};
/// A column of `width` numbers for each hit: value(i, k). NaN if the file has no value.
template <std::size_t width, class Value>
struct VectorColumn {
  static constexpr std::size_t kWidth = width;
  Value value;
};
/// A column of indices; kNone if there is no value.
struct IdColumn {
  static constexpr std::size_t kWidth = 1;
  std::span<const std::uint32_t> ids;
};
/// A column of booleans: value(i) for each hit.
template <class Value>
struct FlagColumn {
  static constexpr std::size_t kWidth = 1;
  Value value;
};
template <class Value>
FlagColumn(Value) -> FlagColumn<Value>;
/// A column of texts; empty if there is no value.
struct NameColumn {
  static constexpr std::size_t kWidth = 1;
  std::span<const std::string_view> names;
};

/// Calls visit(column) with the VectorColumn of `value`.
template <std::size_t width, class Visit, class Value>
void visit_vectors(const Visit& visit, const Value& value) {
  visit(VectorColumn<width, Value>{value});
}

/// Calls visit(column) with the column of an attribute that the file names.
template <class Visit>
void visit_named(const NamedColumn& column, const Visit& visit) {
  const auto value = [&](std::size_t i, std::size_t k) {
    return column.numbers[i * column.width + k];
  };
  switch (column.width) {
    case 1:
      return visit(NumberColumn{column.numbers});
    case 2:
      return visit_vectors<2>(visit, value);
    case 3:
      return visit_vectors<3>(visit, value);
    default:
      return visit_vectors<4>(visit, value);
  }
}

/// Calls visit(column) once, with the column of `field`, which is not kNamed.
template <class Visit>
void visit_column(const HitAnswer& answer, HitField field, const Visit& visit) {
  const HitBatch& hits = answer.hits;
  const HitTerms& terms = answer.terms;
  const auto details = answer.details;
  const auto axis = [](const Vec3d& v, std::size_t k) { return v[static_cast<int>(k)]; };
  switch (field) {
    case HitField::kT:
      return visit(NumberColumn{terms.t_is_distance ? terms.distance : hits.t});
    case HitField::kDistance:
      return visit(NumberColumn{terms.distance});
    case HitField::kInstance:
      return visit(IdColumn{hits.instance});
    case HitField::kPrimitive:
      return visit(IdColumn{terms.primitive});
    case HitField::kTriangle:
      return visit(IdColumn{terms.triangle});
    case HitField::kPosition:
      return visit_vectors<3>(
          visit, [=](std::size_t i, std::size_t k) { return axis(details[i].position, k); });
    case HitField::kNormal:
      return visit_vectors<3>(
          visit, [=](std::size_t i, std::size_t k) { return axis(details[i].normal, k); });
    case HitField::kShadingNormal:
      return visit_vectors<3>(visit, [&](std::size_t i, std::size_t k) {
        return axis(terms.attributes.shading_normal[i], k);
      });
    case HitField::kBarycentrics:
      return visit_vectors<2>(visit, [=](std::size_t i, std::size_t k) {
        return k == 0 ? details[i].u : details[i].v;
      });
    case HitField::kUv:
      return visit_vectors<2>(
          visit, [&](std::size_t i, std::size_t k) { return terms.attributes.uv[i][k]; });
    case HitField::kUv1:
      return visit_vectors<2>(
          visit, [&](std::size_t i, std::size_t k) { return terms.attributes.uv1[i][k]; });
    case HitField::kTangent:
      return visit_vectors<4>(
          visit, [&](std::size_t i, std::size_t k) { return terms.attributes.tangent[i][k]; });
    case HitField::kColour:
      return visit_vectors<4>(
          visit, [&](std::size_t i, std::size_t k) { return terms.attributes.colour[i][k]; });
    case HitField::kFront:
      return visit(FlagColumn{[=](std::size_t i) { return details[i].front; }});
    case HitField::kOnEdge:
      return visit(FlagColumn{[=](std::size_t i) { return details[i].on_edge; }});
    case HitField::kNode:
      return visit(NameColumn{terms.node_name});
    case HitField::kNodeId:
      return visit(IdColumn{terms.node});
    case HitField::kNodePath:
      return visit(NameColumn{terms.node_path});
    case HitField::kMesh:
      return visit(NameColumn{terms.mesh_name});
    case HitField::kMeshId:
      return visit(IdColumn{terms.mesh});
    case HitField::kMaterial:
      return visit(NameColumn{terms.material_name});
    case HitField::kMaterialId:
      return visit(IdColumn{terms.material});
    case HitField::kNodeInstance:
      return visit(IdColumn{terms.node_instance});
    case HitField::kCostNodes:
      return visit(IdColumn{terms.costs.nodes});
    case HitField::kCostBlocks:
      return visit(IdColumn{terms.costs.blocks});
    case HitField::kNamed:
      return;
  }
}

/// Calls visit(name, column) for the column of each of `fields`, in their order, and then of each
/// attribute that the request names. Precondition: `answer` has the data of `fields`. value(i, k)
/// and value(i) may be called for hits only, not for misses.
template <class Visit>
void visit_columns(const HitAnswer& answer, FieldSet fields, const Visit& visit) {
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field)) continue;
    visit_column(answer, field, [&](const auto& column) { visit(hit_field_name(field), column); });
  }
  if (!fields.has(HitField::kNamed)) return;
  for (const NamedColumn& named : answer.terms.attributes.named)
    visit_named(named, [&](const auto& column) { visit(std::string_view(named.name), column); });
}

}  // namespace sightline

// Tests: tests/unit/proto/hit_json_test.cpp
