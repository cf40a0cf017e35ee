#include "proto/binary/hit_csv.h"

#include <cmath>

#include "proto/json/number_text.h"

namespace sightline {
namespace {

void append_text(std::string& out, std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

/// Writes the values of slot `i`, each followed by a comma; no value is an empty cell.
struct CsvCells {
  std::string& out;
  const HitBatch& hits;
  std::size_t i;

  void operator()(const NumberColumn& column) const { append_csv_number(out, column.numbers[i]); }
  template <std::size_t width, class Value>
  void operator()(const VectorColumn<width, Value>& column) const {
    for (std::size_t k = 0; k < width; ++k)
      append_csv_number(out, hits.hit(i) ? column.value(i, k) : kNoNumber);
  }
  void operator()(const IdColumn& column) const {
    if (hits.hit(i) && column.ids[i] != kNone) out += std::to_string(column.ids[i]);
    out += ',';
  }
  template <class Value>
  void operator()(const FlagColumn<Value>& column) const {
    if (hits.hit(i)) out += column.value(i) ? "true" : "false";
    out += ',';
  }
  void operator()(const NameColumn& column) const {
    append_text(out, column.names[i]);
    out += ',';
  }
};

}  // namespace

std::vector<std::string> part_names(std::string_view column, std::size_t width) {
  if (width == 1) return {std::string(column)};
  const std::optional<HitField> field = find_hit_field(column);
  const bool is_vector = field && hit_field_row(*field).kind == FieldKind::kVector;
  const std::string_view letters = field == HitField::kColour ? "rgba"
                                   : width == 4               ? "xyzw"
                                   : width == 2               ? "uv"
                                                              : "xyz";
  std::vector<std::string> names;
  for (std::size_t k = 0; k < width; ++k) {
    const std::string part = is_vector ? std::string(1, letters[k]) : std::to_string(k);
    names.push_back(std::string(column) + "_" + part);
  }
  return names;
}

void append_csv_names(std::string& out, std::string_view prefix, const HitAnswer& answer,
                      FieldSet fields) {
  visit_columns(answer, fields, [&](std::string_view column, const auto& values) {
    for (const std::string& name : part_names(column, values.kWidth))
      out.append(prefix).append(name) += ',';
  });
}

void append_csv_cells(std::string& out, const HitAnswer& answer, FieldSet fields, std::size_t i) {
  visit_columns(answer, fields, [&](std::string_view, const auto& column) {
    CsvCells{out, answer.hits, i}(column);
  });
}

void append_csv_number(std::string& out, double value) {
  char text[kNumberRoom];
  if (std::isfinite(value)) out.append(text, write_json_number(text, value));
  out += ',';
}

}  // namespace sightline
