#include "proto/json/clearance_json.h"

#include <cmath>

#include "proto/hit_columns.h"
#include "proto/json/json_parts.h"

namespace sightline {
namespace {

/// Writes the value of one hit, each number after a comma.
struct CsvValue {
  JsonWriter& out;
  std::size_t i;

  void number(double value) const {
    out.raw(',');
    if (std::isfinite(value)) out.number(value);
  }
  void operator()(const NumberColumn& column) const { number(column.numbers[i]); }
  template <std::size_t width, class Value>
  void operator()(const VectorColumn<width, Value>& column) const {
    for (std::size_t k = 0; k < width; ++k) number(column.value(i, k));
  }
  void operator()(const IdColumn& column) const {
    out.raw(',');
    if (column.ids[i] != kNone) out.number(column.ids[i]);
  }
  template <class Value>
  void operator()(const FlagColumn<Value>& column) const {
    write(out, ',', static_cast<bool>(column.value(i)));
  }
  /// Quoted where the text has a comma, a quote or an end of a line. Nothing for a missing name.
  void operator()(const NameColumn& column) const {
    const std::string_view text = column.names[i];
    out.raw(',');
    if (text.empty()) return;
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return out.raw(text);
    out.raw('"');
    for (const char c : text) {
      if (c == '"') out.raw('"');
      out.raw(c);
    }
    out.raw('"');
  }
};

void write_names(JsonWriter& out, std::string_view side, FieldSet fields) {
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field)) continue;
    const std::size_t width = hit_field_width(field);
    for (std::size_t k = 0; k < width; ++k) {
      write(out, ',', side, '.', hit_field_name(field));
      if (width > 1) write(out, '.', "xyzw"[k]);
    }
  }
}

void write_end(JsonWriter& out, const ClearanceEnds& ends, FieldSet fields, std::size_t i) {
  const HitAnswer answer{ends.hits, ends.details, ends.terms};
  for (const HitField field : all_hit_fields()) {
    if (fields.has(field)) visit_column(answer, field, CsvValue{out, i});
  }
}

}  // namespace

std::string encode_clearance_csv(const ClearanceAnswer& answer, const ClearanceQuestion& question,
                                 FieldSet fields, const ClearanceEnds& a, const ClearanceEnds& b) {
  JsonWriter out(1024 + answer.pairs.size() * 256);
  out.raw(question.kinds ? "kind,depth,distance" : "distance");
  write_names(out, "a", fields);
  write_names(out, "b", fields);
  out.raw("\r\n");
  for (std::size_t i = 0; i < answer.pairs.size(); ++i) {
    const ClearancePair& pair = answer.pairs[i];
    if (question.kinds) {
      out.raw(clash_kind_name(pair.kind));
      CsvValue{out, i}.number(pair.depth);
      out.raw(',');
    }
    out.number(pair.distance);
    write_end(out, a, fields, i);
    write_end(out, b, fields, i);
    out.raw("\r\n");
  }
  return out.take();
}

}  // namespace sightline
