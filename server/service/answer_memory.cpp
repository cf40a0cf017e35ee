#include "server/service/answer_memory.h"

namespace sightline {

std::uint64_t bytes_of_description(std::uint64_t hits, FieldSet fields, std::size_t named) {
  std::uint64_t bytes = 0;
  for (const HitFieldRow& row : kHitFields) {
    if (!fields.has(row.field)) continue;
    bytes += row.source == FieldSource::kAttribute ? numbers_of({row.field}, named) * sizeof(double)
                                                   : sizeof(std::string_view);
  }
  if (fields.has_any_of(kCostFields)) bytes += sizeof(double) + 2 * sizeof(std::uint32_t);
  if (fields.has_any_of(kDetailFields)) bytes += sizeof(HitDetail);
  return hits * bytes;
}

std::uint64_t bytes_of_encoded(std::uint64_t hits, FieldSet fields, const HitTerms& terms) {
  std::uint64_t bytes = 8;
  for (const HitField field : all_hit_fields()) {
    // A vector, and its name.
    if (fields.has(field)) bytes += hit_field_width(field) * kNumberBytes + 20;
  }
  for (const NamedColumn& column : terms.attributes.named)
    bytes += column.width * kNumberBytes + column.name.size() + 4;
  return hits * bytes + bytes_of_names(terms.node_name) + bytes_of_names(terms.node_path) +
         bytes_of_names(terms.mesh_name) + bytes_of_names(terms.material_name);
}

Status describe_within(const ReserveBytes& reserve, const Engine& engine,
                       const DescribedHits& described, const Deadline& deadline,
                       HitDescription& about) {
  const std::size_t hits = described.hits.size();
  Status status =
      ask_for(reserve, bytes_of_description(hits, described.fields, described.named.size()));
  if (status) status = describe_hits(engine, described, deadline, about);
  if (!status) return status;
  return ask_for(reserve, bytes_of_encoded(hits, described.fields, about.terms));
}

std::uint64_t bytes_of_names(std::span<const std::string_view> names) {
  // Six bytes for one, where it is a control character.
  std::uint64_t bytes = 0;
  for (const std::string_view name : names) bytes += 6 * name.size();
  return bytes;
}

}  // namespace sightline
