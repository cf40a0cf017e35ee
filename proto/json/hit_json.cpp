#include "proto/json/hit_json.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "proto/json/hit_rows.h"
#include "proto/json/json_parts.h"
#include "proto/json/number_text.h"

namespace sightline {
namespace {

/// Writes the value of one hit as a member of its row.
struct RowValue {
  JsonWriter& out;
  std::size_t i;

  void operator()(const NumberColumn& column) const { out.number(column.numbers[i]); }
  template <std::size_t width, class Value>
  void operator()(const VectorColumn<width, Value>& column) const {
    if (std::isnan(column.value(i, 0))) return out.raw("null");
    for (std::size_t k = 0; k < width; ++k) {
      out.raw(k == 0 ? '[' : ',');
      out.number(column.value(i, k));
    }
    out.raw(']');
  }
  void operator()(const IdColumn& column) const { write_id(out, column.ids[i]); }
  template <class Value>
  void operator()(const FlagColumn<Value>& column) const {
    out.boolean(column.value(i));
  }
  void operator()(const NameColumn& column) const { out.name(column.names[i]); }
};

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
  visit_columns(answer, fields, [&](std::string_view name, const auto& column) {
    out.raw(before);
    out.raw('"');
    out.raw(name);
    out.raw("\":");
    before = ',';
    RowValue{out, i}(column);
  });
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

/// Writes a column without its brackets, with commas between the values.
struct ColumnValues {
  JsonWriter& out;
  const HitBatch& hits;

  void operator()(const NumberColumn& column) const {
    each(kLongestNumber,
         [&](char* at, std::size_t i) { return write_json_number(at, column.numbers[i]); });
  }
  template <std::size_t width, class Value>
  void operator()(const VectorColumn<width, Value>& column) const {
    each(width * (kLongestNumber + 1), [&](char* at, std::size_t i) {
      for (std::size_t k = 0; k < width; ++k) {
        if (k > 0) *at++ = ',';
        at = write_json_number(at, hits.hit(i) ? column.value(i, k) : kNoNumber);
      }
      return at;
    });
  }
  void operator()(const IdColumn& column) const {
    constexpr ShortText kMinusOne{'-' | '1' << 8, 2};
    each(kLongestNumber, [&](char* at, std::size_t i) {
      return write_integer_or(at, column.ids[i], kNone, kMinusOne);
    });
  }
  template <class Value>
  void operator()(const FlagColumn<Value>& column) const {
    each(kLongestNumber, [&](char* at, std::size_t i) {
      const std::string_view text = !hits.hit(i) ? "null" : column.value(i) ? "true" : "false";
      std::memcpy(at, text.data(), text.size());
      return at + text.size();
    });
  }
  void operator()(const NameColumn& column) const {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (i > 0) out.raw(',');
      out.name(column.names[i]);
    }
  }

 private:
  /// write(at, i) returns the end of what it has written, at most so many bytes.
  template <class Write>
  void each(std::size_t longest, const Write& write) const {
    // Some at a time, so that neither their room nor their place is computed for each.
    constexpr std::size_t kTogether = 64;
    for (std::size_t begin = 0; begin < hits.size(); begin += kTogether) {
      const std::size_t end = std::min(hits.size(), begin + kTogether);
      char* at = out.room((end - begin) * (longest + 1) + kNumberRoom);
      for (std::size_t i = begin; i < end; ++i) {
        *at = ',';
        at = write(at + (i > 0 ? 1 : 0), i);
      }
      out.written_to(at);
    }
  }
};

/// The columns of all fields asked for, with commas between them.
void write_columns(JsonWriter& out, const HitAnswer& answer, FieldSet fields) {
  bool first = true;
  visit_columns(answer, fields, [&](std::string_view name, const auto& column) {
    out.raw(first ? "\"" : ",\"");
    first = false;
    out.raw(name);
    out.raw("\":[");
    ColumnValues{out, answer.hits}(column);
    out.raw(']');
  });
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
