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

/// Appends the values of all fields of slot `i`.
template <class Id>
void append_packed(std::string& out, const HitAnswer& answer, FieldSet fields, std::size_t i) {
  visit_columns(answer, fields, [&](std::string_view, const auto& column) {
    PackedCells<Id>{out, answer.hits, i}(column);
  });
}

std::string encode_csv(const HitAnswer& answer, FieldSet fields) {
  std::string out;
  const auto end_line = [&] {
    out.pop_back();
    out += "\r\n";
  };
  append_csv_names(out, "", answer, fields);
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

/// Adds the numbers of a column.
struct PointNumbers {
  std::vector<PointNumber>& numbers;
  bool is_ply;
  std::string_view column;

  void operator()(const NumberColumn& values) const { add(values.kWidth, 'F', 8); }
  template <std::size_t width, class Value>
  void operator()(const VectorColumn<width, Value>&) const {
    add(width, 'F', 8);
  }
  void operator()(const IdColumn& values) const { add(values.kWidth, 'I', 4); }
  template <class Value>
  void operator()(const FlagColumn<Value>& values) const {
    add(values.kWidth, 'U', 1);
  }
  void operator()(const NameColumn&) const {}

 private:
  void add(std::size_t width, char type, int bytes) const {
    for (const std::string& name : part_names(column, width))
      numbers.push_back({short_name(name, is_ply), type, bytes});
  }
};

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
  // The parts of a colour are those of the point.
  FieldSet numbers = fields;
  numbers.remove(HitField::kColour);
  std::size_t points = 0;
  for (std::size_t i = 0; i < answer.hits.size(); ++i) points += answer.hits.hit(i) ? 1u : 0u;
  std::vector<PointNumber> described{{"ray", 'U', 4}};
  visit_columns(answer, numbers, [&](std::string_view name, const auto& column) {
    PointNumbers{described, is_ply, name}(column);
  });
  std::string out = is_ply ? ply_head(described, colours.has_any(), points)
                           : pcd_head(described, colours.has_any(), points);
  for (std::size_t i = 0; i < answer.hits.size(); ++i) {
    if (!answer.hits.hit(i)) continue;
    append_number(out, static_cast<std::uint32_t>(i));
    append_packed<std::int32_t>(out, answer, numbers, i);
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

/// The type of a column's values in an array.
struct NumpyType {
  std::string_view operator()(const NumberColumn&) const { return "'<f8'"; }
  template <std::size_t width, class Value>
  std::string_view operator()(const VectorColumn<width, Value>&) const {
    return "'<f8'";
  }
  template <class Value>
  std::string_view operator()(const FlagColumn<Value>&) const {
    return "'|b1'";
  }
  std::string_view operator()(const IdColumn&) const { return "'<i8'"; }
  std::string_view operator()(const NameColumn&) const { return ""; }
};

std::string encode_npy(const HitAnswer& answer, FieldSet fields) {
  std::string type;
  visit_columns(answer, fields, [&](std::string_view name, const auto& column) {
    type.append(type.empty() ? "('" : ", ('")
        .append(name)
        .append("', ")
        .append(NumpyType()(column));
    if (column.kWidth > 1) type += ", (" + std::to_string(column.kWidth) + ",)";
    type += ")";
  });
  std::string out = npy_head("[" + type + "]", std::to_string(answer.hits.size()) + ",");
  for (std::size_t i = 0; i < answer.hits.size(); ++i)
    append_packed<std::int64_t>(out, answer, fields, i);
  return out;
}

std::string encode_npz(const HitAnswer& answer, FieldSet fields) {
  ZipArchive archive;
  visit_columns(answer, fields, [&](std::string_view name, const auto& column) {
    std::string file =
        npy_head(std::string(NumpyType()(column)),
                 std::to_string(answer.hits.size()) + "," +
                     (column.kWidth > 1 ? std::to_string(column.kWidth) : std::string()));
    for (std::size_t i = 0; i < answer.hits.size(); ++i)
      PackedCells<std::int64_t>{file, answer.hits, i}(column);
    archive.add(std::string(name) + ".npy", file);
  });
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
