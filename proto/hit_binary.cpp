#include "proto/hit_binary.h"

#include <algorithm>
#include <array>
#include <limits>

#include "proto/binary_answer.h"
#include "proto/ray_binary.h"

namespace sightline {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// As BINARY.md numbers them.
std::uint8_t fault_number(std::string_view code) {
  constexpr std::array<std::string_view, 4> kCodes{"RAY_NOT_FINITE", "RAY_DIRECTION_ZERO",
                                                   "RAY_LIMIT_NAN", "RAY_LIMITS_REVERSED"};
  const auto found = std::find(kCodes.begin(), kCodes.end(), code);
  return static_cast<std::uint8_t>(found - kCodes.begin() + 1);
}

void write_invalid(BinaryAnswer& answer, const InvalidRays& invalid) {
  std::size_t seen = 0;
  answer.next<std::uint8_t>([&](std::size_t ray, std::uint32_t) -> std::uint8_t {
    if (seen == invalid.number.size() || invalid.number[seen] != ray) return 0;
    return fault_number(invalid.code[seen++]);
  });
}

/// The numbers of one column of a hit, or what says "nothing".
struct HitColumns {
  const HitBatch& hits;
  std::span<const HitDetail> details;
  const HitTerms& terms;
  FieldSet fields;

  template <class Visit>
  void each(Visit visit) const {
    for (const HitField field : all_hit_fields()) {
      if (fields.has(field) && !kTextFields.has(field)) visit(field);
    }
  }
  void announce_all(BinaryAnswer& answer) const {
    each([&](HitField field) {
      const std::string_view name = hit_field_name(field);
      switch (field) {
        case HitField::kT:
        case HitField::kDistance:
          return answer.announce<double>(name, hits.size());
        case HitField::kPosition:
        case HitField::kNormal:
        case HitField::kShadingNormal:
        case HitField::kBarycentrics:
        case HitField::kUv:
        case HitField::kColour:
          return answer.announce<double>(name, hits.size(),
                                         static_cast<std::uint32_t>(hit_field_width(field)));
        case HitField::kFront:
        case HitField::kOnEdge:
          return answer.announce<std::uint8_t>(name, hits.size());
        default:
          return answer.announce<std::uint32_t>(name, hits.size());
      }
    });
  }
  void write_all(BinaryAnswer& answer) const {
    each([&](HitField field) { write(answer, field); });
  }

 private:
  template <class Value>
  void numbers(BinaryAnswer& answer, Value value) const {
    answer.next<double>([&](std::size_t i, std::uint32_t k) {
      return hits.hit(i) ? value(details[i], static_cast<int>(k)) : kNan;
    });
  }
  template <class Value>
  void flags(BinaryAnswer& answer, Value value) const {
    answer.next<std::uint8_t>([&](std::size_t i, std::uint32_t) {
      return hits.hit(i) ? (value(details[i]) ? 1 : 0) : 255;
    });
  }
  void ids(BinaryAnswer& answer, const Column<std::uint32_t>& column) const {
    answer.next<std::uint32_t>([&](std::size_t i, std::uint32_t) { return column[i]; });
  }
  void write(BinaryAnswer& answer, HitField field) const {
    switch (field) {
      case HitField::kT:
        return answer.next<double>([&](std::size_t i, std::uint32_t) {
          return terms.t_is_distance ? terms.distance[i] : hits.t[i];
        });
      case HitField::kDistance:
        return answer.next<double>([&](std::size_t i, std::uint32_t) { return terms.distance[i]; });
      case HitField::kPosition:
        return numbers(answer, [](const HitDetail& d, int k) { return d.position[k]; });
      case HitField::kNormal:
        return numbers(answer, [](const HitDetail& d, int k) { return d.normal[k]; });
      case HitField::kShadingNormal:
        return answer.next<double>([&](std::size_t i, std::uint32_t k) {
          return terms.attributes.shading_normal[i][static_cast<int>(k)];
        });
      case HitField::kUv:
        return answer.next<double>(
            [&](std::size_t i, std::uint32_t k) { return terms.attributes.uv[i][k]; });
      case HitField::kColour:
        return answer.next<double>(
            [&](std::size_t i, std::uint32_t k) { return terms.attributes.colour[i][k]; });
      case HitField::kBarycentrics:
        return numbers(answer, [](const HitDetail& d, int k) { return k == 0 ? d.u : d.v; });
      case HitField::kFront:
        return flags(answer, [](const HitDetail& d) { return d.front; });
      case HitField::kOnEdge:
        return flags(answer, [](const HitDetail& d) { return d.on_edge; });
      case HitField::kInstance:
        return ids(answer, hits.instance);
      case HitField::kPrimitive:
        return ids(answer, terms.primitive);
      case HitField::kTriangle:
        return ids(answer, terms.triangle);
      case HitField::kNodeId:
        return ids(answer, terms.node);
      case HitField::kMeshId:
        return ids(answer, terms.mesh);
      case HitField::kMaterialId:
        return ids(answer, terms.material);
      case HitField::kNode:
      case HitField::kNodePath:
      case HitField::kMesh:
      case HitField::kMaterial:
        return;  // texts
    }
  }
};

/// The answer of one column, one number for each ray.
template <class Number, class Source>
std::string encode_one(std::string_view name, std::span<const Source> values,
                       const InvalidRays* invalid) {
  BinaryAnswer answer;
  answer.announce<Number>(name, values.size());
  if (invalid != nullptr) answer.announce<std::uint8_t>("invalid", values.size());
  answer.begin();
  answer.next<Number>([&](std::size_t i, std::uint32_t) { return values[i]; });
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

}  // namespace

Status check_binary_fields(FieldSet fields) {
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field) || !kTextFields.has(field)) continue;
    return Error{ErrorKind::kInvalid, "FIELD_IS_TEXT",
                 "a binary answer has no texts: ask for ids instead of \"" +
                     std::string(hit_field_name(field)) + "\"",
                 "/fields"};
  }
  return success();
}

std::string encode_hits_binary(const HitBatch& hits, std::span<const HitDetail> details,
                               const HitTerms& terms, FieldSet fields, const InvalidRays* invalid) {
  const HitColumns columns{hits, details, terms, fields};
  BinaryAnswer answer;
  columns.announce_all(answer);
  if (invalid != nullptr) answer.announce<std::uint8_t>("invalid", hits.size());
  answer.begin();
  columns.write_all(answer);
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

std::string encode_hit_lists_binary(const HitLists& lists, std::span<const std::uint64_t> totals,
                                    std::span<const HitDetail> details, const HitTerms& terms,
                                    FieldSet fields, const InvalidRays* invalid) {
  const HitColumns columns{lists.hits, details, terms, fields};
  BinaryAnswer answer;
  answer.announce<std::uint64_t>("totals", totals.size());
  answer.announce<std::uint64_t>("first", lists.first.size());
  columns.announce_all(answer);
  if (invalid != nullptr) answer.announce<std::uint8_t>("invalid", totals.size());
  answer.begin();
  answer.next<std::uint64_t>([&](std::size_t i, std::uint32_t) { return totals[i]; });
  answer.next<std::uint64_t>([&](std::size_t i, std::uint32_t) { return lists.first[i]; });
  columns.write_all(answer);
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

std::string encode_nearest_lists_binary(const HitLists& lists, std::span<const HitDetail> details,
                                        const HitTerms& terms, FieldSet fields) {
  const HitColumns columns{lists.hits, details, terms, fields};
  BinaryAnswer answer;
  answer.announce<std::uint64_t>("first", lists.first.size());
  columns.announce_all(answer);
  answer.begin();
  answer.next<std::uint64_t>([&](std::size_t i, std::uint32_t) { return lists.first[i]; });
  columns.write_all(answer);
  return answer.take();
}

std::string encode_counts_binary(std::span<const std::uint64_t> counts,
                                 const InvalidRays* invalid) {
  return encode_one<std::uint64_t>("counts", counts, invalid);
}

std::string encode_occlusion_binary(std::span<const std::uint8_t> occluded,
                                    const InvalidRays* invalid) {
  return encode_one<std::uint8_t>("hits", occluded, invalid);
}

}  // namespace sightline
