#include "proto/hit_json.h"

#include <cmath>

#include "proto/hit_rows.h"
#include "proto/json_writer.h"

namespace sightline {
namespace {

/// Whether a column of this field says -1 where there is nothing.
bool is_id(HitField field) {
  switch (field) {
    case HitField::kInstance:
    case HitField::kPrimitive:
    case HitField::kTriangle:
    case HitField::kNodeId:
    case HitField::kMeshId:
    case HitField::kMaterialId:
      return true;
    default:
      return false;
  }
}

void write_id(JsonWriter& out, std::uint32_t id, std::string_view nothing) {
  if (id == kNone) {
    out.raw(nothing);
  } else {
    out.number(id);
  }
}

void write_numbers(JsonWriter& out, const Vec3d& v) {
  out.number(v.x);
  out.raw(',');
  out.number(v.y);
  out.raw(',');
  out.number(v.z);
}

template <std::size_t n>
void write_numbers(JsonWriter& out, const std::array<double, n>& numbers) {
  for (std::size_t k = 0; k < n; ++k) {
    if (k > 0) out.raw(',');
    out.number(numbers[k]);
  }
}

/// Whether the file says nothing of this at a hit.
bool is_unknown(const HitAnswer& answer, HitField field, std::size_t i) {
  const HitAttributes& attributes = answer.terms.attributes;
  switch (field) {
    case HitField::kShadingNormal:
      return std::isnan(attributes.shading_normal[i].x);
    case HitField::kUv:
      return std::isnan(attributes.uv[i][0]);
    case HitField::kColour:
      return std::isnan(attributes.colour[i][0]);
    default:
      return false;
  }
}

/// The value of a hit without the brackets of a vector. Precondition: slot i is a hit.
void write_value(JsonWriter& out, const HitAnswer& answer, HitField field, std::size_t i,
                 std::string_view no_id) {
  const HitTerms& terms = answer.terms;
  switch (field) {
    case HitField::kT:
      return out.number(terms.t_is_distance ? terms.distance[i] : answer.hits.t[i]);
    case HitField::kDistance:
      return out.number(terms.distance[i]);
    case HitField::kInstance:
      return write_id(out, answer.hits.instance[i], no_id);
    case HitField::kPrimitive:
      return write_id(out, terms.primitive[i], no_id);
    case HitField::kTriangle:
      return write_id(out, terms.triangle[i], no_id);
    case HitField::kPosition:
      return write_numbers(out, answer.details[i].position);
    case HitField::kNormal:
      return write_numbers(out, answer.details[i].normal);
    case HitField::kShadingNormal:
      return write_numbers(out, terms.attributes.shading_normal[i]);
    case HitField::kUv:
      return write_numbers(out, terms.attributes.uv[i]);
    case HitField::kColour:
      return write_numbers(out, terms.attributes.colour[i]);
    case HitField::kBarycentrics:
      out.number(answer.details[i].u);
      out.raw(',');
      return out.number(answer.details[i].v);
    case HitField::kFront:
      return out.boolean(answer.details[i].front);
    case HitField::kOnEdge:
      return out.boolean(answer.details[i].on_edge);
    case HitField::kNode:
      return out.name(terms.node_name[i]);
    case HitField::kNodeId:
      return write_id(out, terms.node[i], no_id);
    case HitField::kNodePath:
      return out.name(terms.node_path[i]);
    case HitField::kMesh:
      return out.name(terms.mesh_name[i]);
    case HitField::kMeshId:
      return write_id(out, terms.mesh[i], no_id);
    case HitField::kMaterial:
      return out.name(terms.material_name[i]);
    case HitField::kMaterialId:
      return write_id(out, terms.material[i], no_id);
  }
}

}  // namespace

void write_triangle_members(JsonWriter& out, std::uint32_t instance, const HitTerms& terms,
                            std::size_t i) {
  out.raw("\"instance\":");
  out.number(instance);
  out.raw(",\"primitive\":");
  out.number(terms.primitive[i]);
  out.raw(",\"triangle\":");
  out.number(terms.triangle[i]);
  out.raw(",\"node\":");
  out.name(terms.node_name[i]);
  out.raw(",\"mesh\":");
  out.name(terms.mesh_name[i]);
}

void write_row(JsonWriter& out, const HitAnswer& answer, FieldSet fields, std::size_t i) {
  if (!answer.hits.hit(i)) return out.raw("null");
  char before = '{';
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field)) continue;
    out.raw(before);
    out.raw('"');
    out.raw(hit_field_name(field));
    out.raw("\":");
    before = ',';
    if (is_unknown(answer, field, i)) {
      out.raw("null");
      continue;
    }
    if (hit_field_width(field) > 1) out.raw('[');
    write_value(out, answer, field, i, "null");
    if (hit_field_width(field) > 1) out.raw(']');
  }
  if (before == '{') out.raw('{');
  out.raw('}');
}

namespace {

/// Those from `begin` to `end`, with commas between them.
void write_rows(JsonWriter& out, const HitAnswer& answer, FieldSet fields, std::size_t begin,
                std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    if (i > begin) out.raw(',');
    write_row(out, answer, fields, i);
  }
}

void write_column(JsonWriter& out, const HitAnswer& answer, HitField field) {
  out.raw('"');
  out.raw(hit_field_name(field));
  out.raw("\":[");
  constexpr std::string_view kNulls = "null,null,null,null", kNoId = "-1";
  const std::string_view nothing =
      is_id(field) ? kNoId : kNulls.substr(0, hit_field_width(field) * 5 - 1);
  for (std::size_t i = 0; i < answer.hits.size(); ++i) {
    if (i > 0) out.raw(',');
    if (answer.hits.hit(i)) {
      write_value(out, answer, field, i, kNoId);
    } else {
      out.raw(nothing);
    }
  }
  out.raw(']');
}

/// The columns of all fields asked for, with commas between them.
void write_columns(JsonWriter& out, const HitAnswer& answer, FieldSet fields) {
  bool first = true;
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field)) continue;
    if (!first) out.raw(',');
    first = false;
    write_column(out, answer, field);
  }
}

template <class Number>
void write_array(JsonWriter& out, std::span<const Number> numbers) {
  out.raw('[');
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) out.raw(',');
    out.number(std::uint64_t{numbers[i]});
  }
  out.raw(']');
}

}  // namespace

std::size_t expected_hit_bytes(FieldSet fields) {
  std::size_t bytes = 8;
  for (const HitField field : all_hit_fields()) {
    if (fields.has(field)) bytes += 18 * hit_field_width(field) + 12;
  }
  return bytes;
}

std::string encode_hits(const HitBatch& hits, std::span<const HitDetail> details,
                        const HitTerms& terms, FieldSet fields, AnswerLayout layout) {
  const HitAnswer answer{hits, details, terms};
  JsonWriter out(32 + hits.size() * expected_hit_bytes(fields));
  if (layout == AnswerLayout::kRows) {
    out.raw("{\"hits\":[");
    write_rows(out, answer, fields, 0, hits.size());
    out.raw("]}");
    return out.take();
  }
  out.raw('{');
  write_columns(out, answer, fields);
  out.raw('}');
  return out.take();
}

std::string encode_hit_lists(const HitLists& lists, std::span<const std::uint64_t> totals,
                             std::span<const HitDetail> details, const HitTerms& terms,
                             FieldSet fields, AnswerLayout layout) {
  const HitAnswer answer{lists.hits, details, terms};
  JsonWriter out(32 + totals.size() * 24 + lists.hits.size() * expected_hit_bytes(fields));
  if (layout == AnswerLayout::kColumns) {
    out.raw("{\"totals\":");
    write_array(out, totals);
    out.raw(",\"first\":");
    write_array(out, std::span<const std::size_t>(lists.first));
    if (!fields.empty()) out.raw(',');
    write_columns(out, answer, fields);
    out.raw('}');
    return out.take();
  }
  out.raw("{\"results\":[");
  for (std::size_t ray = 0; ray < totals.size(); ++ray) {
    out.raw(ray > 0 ? ",{\"total\":" : "{\"total\":");
    out.number(totals[ray]);
    out.raw(",\"hits\":[");
    write_rows(out, answer, fields, lists.first[ray], lists.first[ray + 1]);
    out.raw("]}");
  }
  out.raw("]}");
  return out.take();
}

std::string encode_nearest_lists(const HitLists& lists, std::span<const HitDetail> details,
                                 const HitTerms& terms, FieldSet fields) {
  const HitAnswer answer{lists.hits, details, terms};
  JsonWriter out(32 + lists.first.size() * 12 + lists.hits.size() * expected_hit_bytes(fields));
  out.raw("{\"results\":[");
  for (std::size_t point = 0; point + 1 < lists.first.size(); ++point) {
    out.raw(point > 0 ? ",{\"hits\":[" : "{\"hits\":[");
    write_rows(out, answer, fields, lists.first[point], lists.first[point + 1]);
    out.raw("]}");
  }
  out.raw("]}");
  return out.take();
}

std::string encode_hit(const HitBatch& hits, std::span<const HitDetail> details,
                       const HitTerms& terms, FieldSet fields, std::size_t i) {
  JsonWriter out(expected_hit_bytes(fields));
  write_row(out, {hits, details, terms}, fields, i);
  return out.take();
}

std::string encode_counts(std::span<const std::uint64_t> counts) {
  JsonWriter out(16 + counts.size() * 4);
  out.raw("{\"counts\":");
  write_array(out, counts);
  out.raw('}');
  return out.take();
}

std::string encode_occlusion(std::span<const std::uint8_t> occluded) {
  JsonWriter out(16 + occluded.size() * 6);
  out.raw("{\"hits\":[");
  for (std::size_t i = 0; i < occluded.size(); ++i) {
    if (i > 0) out.raw(',');
    out.boolean(occluded[i] != 0);
  }
  out.raw("]}");
  return out.take();
}

}  // namespace sightline
