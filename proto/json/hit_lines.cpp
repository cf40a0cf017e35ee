#include "proto/json/hit_lines.h"

#include "proto/json/hit_rows.h"

namespace sightline {
namespace {

/// write(out, i) for each ray that is good.
template <class Write>
std::string encode_lines(std::size_t count, std::size_t bytes_each, const InvalidRays* invalid,
                         Write write) {
  JsonWriter out(16 + count * bytes_each);
  std::size_t bad = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (invalid != nullptr && bad < invalid->number.size() && invalid->number[bad] == i) {
      out.raw("{\"invalid\":\"");
      out.raw(invalid->code[bad++]);
      out.raw("\"}\n");
      continue;
    }
    write(out, i);
    out.raw('\n');
  }
  return out.take();
}

}  // namespace

std::string encode_hit_lines(const HitBatch& hits, std::span<const HitDetail> details,
                             const HitTerms& terms, FieldSet fields, const InvalidRays* invalid) {
  const HitAnswer answer{hits, details, terms};
  return encode_lines(hits.size(), expected_hit_bytes(fields), invalid,
                      [&](JsonWriter& out, std::size_t i) { write_row(out, answer, fields, i); });
}

std::string encode_hit_list_lines(const HitLists& lists, std::span<const std::uint64_t> totals,
                                  std::span<const HitDetail> details, const HitTerms& terms,
                                  FieldSet fields, const InvalidRays* invalid) {
  const HitAnswer answer{lists.hits, details, terms};
  return encode_lines(totals.size(), 32, invalid, [&](JsonWriter& out, std::size_t ray) {
    out.raw("{\"total\":");
    out.number(totals[ray]);
    out.raw(",\"hits\":[");
    for (std::size_t i = lists.first[ray]; i < lists.first[ray + 1]; ++i) {
      if (i > lists.first[ray]) out.raw(',');
      write_row(out, answer, fields, i);
    }
    out.raw("]}");
  });
}

std::string encode_count_lines(std::span<const std::uint64_t> counts, const InvalidRays* invalid) {
  return encode_lines(counts.size(), 4, invalid,
                      [&](JsonWriter& out, std::size_t i) { out.number(counts[i]); });
}

std::string encode_occlusion_lines(std::span<const std::uint8_t> occluded,
                                   const InvalidRays* invalid) {
  return encode_lines(occluded.size(), 6, invalid,
                      [&](JsonWriter& out, std::size_t i) { out.boolean(occluded[i] != 0); });
}

}  // namespace sightline
