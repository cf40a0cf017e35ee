#include "proto/binary/hit_table.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "proto/binary/hit_csv.h"
#include "proto/binary/numpy_file.h"
#include "proto/hit_columns.h"
#include "proto/node_colour.h"

namespace sightline {
namespace {

/// Calls visit(column of the field) for each field, in their order.
template <class Visit>
void for_each_column(const HitAnswer& answer, FieldSet fields, const Visit& visit) {
  for (const HitField field : all_hit_fields()) {
    if (fields.has(field)) visit_column(answer, field, visit);
  }
}

/// Writes the values of slot `i` as little-endian numbers: float64, `Id` and a byte for a flag.
template <class Id>
struct PackedCells {
  std::string& out;
  const HitBatch& hits;
  std::size_t i;

  void operator()(const NumberColumn& column) const { append_number(out, column.numbers[i]); }
  template <std::size_t width, class Value>
  void operator()(const VectorColumn<width, Value>& column) const {
    for (std::size_t k = 0; k < width; ++k)
      append_number(out, hits.hit(i) ? column.value(i, k) : kNoNumber);
  }
  void operator()(const IdColumn& column) const {
    const bool is_none = !hits.hit(i) || column.ids[i] == kNone;
    append_number(out, is_none ? Id{-1} : static_cast<Id>(column.ids[i]));
  }
  template <class Value>
  void operator()(const FlagColumn<Value>& column) const {
    append_number(out, static_cast<std::uint8_t>(hits.hit(i) && column.value(i) ? 1 : 0));
  }
  void operator()(const NameColumn&) const {}
};

std::string encode_csv(const HitAnswer& answer, FieldSet fields) {
  std::string out;
  const auto end_line = [&] {
    out.pop_back();
    out += "\r\n";
  };
  append_csv_names(out, "", fields);
  end_line();
  for (std::size_t i = 0; i < answer.hits.size(); ++i) {
    append_csv_cells(out, answer, fields, i);
    end_line();
  }
  return out;
}

// Point clouds.

/// The colour of a point: of its vertices if that is requested, else of its node. Empty if neither
/// field is requested.
struct PointColours {
  const HitAnswer& answer;
  FieldSet fields;

  bool has_any() const { return fields.has_any_of({HitField::kColour, HitField::kNodeId}); }
  std::array<std::uint8_t, 3> operator()(std::size_t i) const {
    if (!fields.has(HitField::kColour)) return node_colour(answer.terms.node[i]);
    std::array<std::uint8_t, 3> colour{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = answer.terms.attributes.colour[i][k];
      colour[k] = value > 0 ? static_cast<std::uint8_t>(std::lround(255 * std::fmin(value, 1))) : 0;
    }
    return colour;
  }
};

/// A number of a point: its name, PCD's letter of its type, and its bytes.
struct PointNumber {
  std::string name;
  char type;
  int bytes;
};

std::string short_name(const std::string& name, bool is_ply) {
  if (name.starts_with("position_")) return name.substr(9);
  if (is_ply && name.starts_with("normal_")) return "n" + name.substr(7);
  return name;
}

/// The numbers of a point without its colour: the number of its ray first.
std::vector<PointNumber> point_numbers(FieldSet fields, bool is_ply) {
  std::vector<PointNumber> numbers{{"ray", 'U', 4}};
  for (const HitField field : all_hit_fields()) {
    const FieldKind kind = hit_field_row(field).kind;
    // The parts of a colour are those of the point.
    if (!fields.has(field) || field == HitField::kColour) continue;
    const bool is_float = kind == FieldKind::kNumber || kind == FieldKind::kVector;
    for (const std::string& name : hit_column_names(field)) {
      numbers.push_back({short_name(name, is_ply),
                         is_float                   ? 'F'
                         : kind == FieldKind::kFlag ? 'U'
                                                    : 'I',
                         is_float                   ? 8
                         : kind == FieldKind::kFlag ? 1
                                                    : 4});
    }
  }
  return numbers;
}

std::string ply_head(const std::vector<PointNumber>& numbers, bool has_colour, std::size_t points) {
  std::string head =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points) + "\n";
  for (const PointNumber& each : numbers) {
    const char* const type = each.type == 'F'   ? "double "
                             : each.bytes == 1  ? "uchar "
                             : each.type == 'U' ? "uint "
                                                : "int ";
    head += "property " + std::string(type) + each.name + "\n";
  }
  if (has_colour) head += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  return head + "end_header\n";
}

std::string pcd_head(std::vector<PointNumber> numbers, bool has_colour, std::size_t points) {
  if (has_colour) numbers.push_back({"rgb", 'U', 4});
  std::string fields = "FIELDS", sizes = "\nSIZE", types = "\nTYPE", counts = "\nCOUNT";
  for (const PointNumber& each : numbers) {
    fields += " " + each.name;
    sizes += " " + std::to_string(each.bytes);
    types += std::string(" ") + each.type;
    counts += " 1";
  }
  const std::string count = std::to_string(points);
  return "VERSION 0.7\n" + fields + sizes + types + counts + "\nWIDTH " + count +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
}

std::string encode_points(const HitAnswer& answer, FieldSet fields, bool is_ply) {
  const PointColours colours{answer, fields};
  FieldSet numbers = fields;
  numbers.remove(HitField::kColour);
  std::size_t points = 0;
  for (std::size_t i = 0; i < answer.hits.size(); ++i) points += answer.hits.hit(i) ? 1u : 0u;
  const auto described = point_numbers(fields, is_ply);
  std::string out = is_ply ? ply_head(described, colours.has_any(), points)
                           : pcd_head(described, colours.has_any(), points);
  for (std::size_t i = 0; i < answer.hits.size(); ++i) {
    if (!answer.hits.hit(i)) continue;
    append_number(out, static_cast<std::uint32_t>(i));
    for_each_column(answer, numbers, PackedCells<std::int32_t>{out, answer.hits, i});
    if (!colours.has_any()) continue;
    const auto [red, green, blue] = colours(i);
    // PCD's colour is one integer, 0x00rrggbb.
    const std::array<std::uint8_t, 3> ply{red, green, blue}, pcd{blue, green, red};
    for (const std::uint8_t part : is_ply ? ply : pcd) append_number(out, part);
    if (!is_ply) append_number(out, std::uint8_t{0});
  }
  return out;
}

// NumPy.

/// The type of a field's values in an array, and the shape of a value, "(3,)".
std::string numpy_type(HitField field) {
  const FieldKind kind = hit_field_row(field).kind;
  return kind == FieldKind::kFlag                                   ? "'|b1'"
         : kind == FieldKind::kNumber || kind == FieldKind::kVector ? "'<f8'"
                                                                    : "'<i8'";
}

std::string encode_npy(const HitAnswer& answer, FieldSet fields) {
  std::string type;
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field)) continue;
    type += (type.empty() ? "('" : ", ('") + std::string(hit_field_name(field)) + "', " +
            numpy_type(field);
    const std::size_t width = hit_field_width(field);
    if (width > 1) type += ", (" + std::to_string(width) + ",)";
    type += ")";
  }
  std::string out = npy_head("[" + type + "]", std::to_string(answer.hits.size()) + ",");
  for (std::size_t i = 0; i < answer.hits.size(); ++i) {
    for_each_column(answer, fields, PackedCells<std::int64_t>{out, answer.hits, i});
  }
  return out;
}

std::string encode_npz(const HitAnswer& answer, FieldSet fields) {
  ZipArchive archive;
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field)) continue;
    const std::size_t width = hit_field_width(field);
    std::string file =
        npy_head(numpy_type(field), std::to_string(answer.hits.size()) + "," +
                                        (width > 1 ? std::to_string(width) : std::string()));
    for (std::size_t i = 0; i < answer.hits.size(); ++i) {
      visit_column(answer, field, PackedCells<std::int64_t>{file, answer.hits, i});
    }
    archive.add(std::string(hit_field_name(field)) + ".npy", file);
  }
  return archive.take();
}

}  // namespace

std::string encode_hit_table(TableFormat format, const HitBatch& hits,
                             std::span<const HitDetail> details, const HitTerms& terms,
                             FieldSet fields) {
  const HitAnswer answer{hits, details, terms};
  switch (format) {
    case TableFormat::kPly:
      return encode_points(answer, fields, true);
    case TableFormat::kPcd:
      return encode_points(answer, fields, false);
    case TableFormat::kNpy:
      return encode_npy(answer, fields);
    case TableFormat::kNpz:
      return encode_npz(answer, fields);
    case TableFormat::kCsv:
      break;
  }
  return encode_csv(answer, fields);
}

}  // namespace sightline
