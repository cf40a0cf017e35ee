#include "proto/binary/column_table.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "core/query/hit_batch.h"
#include "proto/binary/hit_csv.h"
#include "proto/binary/numpy_file.h"

namespace sightline {
namespace {

template <class T>
T number_at(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

/// A column of the answer.
struct AnsweredColumn {
  std::string name;
  std::uint32_t type;  ///< docs/reference/binary.md
  std::uint32_t width;
  std::uint64_t rows;
  std::string_view bytes;

  std::size_t number_bytes() const {
    constexpr std::size_t kSizes[] = {0, 8, 4, 1, 8, 8, 4};
    return kSizes[type];
  }
  /// True if number `i` is an id that is none.
  bool is_none(std::size_t i) const {
    return type == 2 && number_at<std::uint32_t>(bytes, i * number_bytes()) == kNone;
  }
  /// Calls visit with number `i`; an id that is none is -1.
  template <class Visit>
  void visit(std::size_t i, const Visit& visit) const {
    const std::size_t at = i * number_bytes();
    switch (type) {
      case 1:
        return visit(number_at<double>(bytes, at));
      case 2: {
        const auto id = number_at<std::uint32_t>(bytes, at);
        return visit(id == kNone ? std::int64_t{-1} : std::int64_t{id});
      }
      case 3:
        return visit(number_at<std::uint8_t>(bytes, at));
      case 4:
        return visit(number_at<std::uint64_t>(bytes, at));
      case 5:
        return visit(number_at<std::int64_t>(bytes, at));
      default:
        return visit(number_at<float>(bytes, at));
    }
  }
  std::string numpy_type() const {
    constexpr const char* kTypes[] = {"", "'<f8'", "'<i8'", "'|u1'", "'<u8'", "'<i8'", "'<f4'"};
    return kTypes[type];
  }
};

std::vector<AnsweredColumn> columns_of(std::string_view answer) {
  constexpr std::size_t kHeaderBytes = 16, kEntryBytes = 40, kNameBytes = 16;
  std::vector<AnsweredColumn> columns(number_at<std::uint32_t>(answer, 4));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::size_t at = kHeaderBytes + i * kEntryBytes;
    const std::string_view name = answer.substr(at, kNameBytes);
    AnsweredColumn& column = columns[i];
    column.name = name.substr(0, name.find('\0'));
    column.type = number_at<std::uint32_t>(answer, at + 16);
    column.width = number_at<std::uint32_t>(answer, at + 20);
    column.rows = number_at<std::uint64_t>(answer, at + 32);
    column.bytes = answer.substr(number_at<std::uint64_t>(answer, at + 24),
                                 column.rows * column.width * column.number_bytes());
  }
  return columns;
}

/// Replaces the columns of the lists of rows, `first` and its companions, by the number of the list
/// of each row, for tables that have one row for each line. `numbers` stores them.
void number_lists(std::vector<AnsweredColumn>& columns, std::string& numbers) {
  std::vector<AnsweredColumn> rows;
  const AnsweredColumn* first = nullptr;
  for (const AnsweredColumn& column : columns) {
    if (column.name == "first") first = &column;
  }
  if (first == nullptr) return;
  for (std::uint64_t list = 0; list + 1 < first->rows; ++list) {
    const auto begin = number_at<std::uint64_t>(first->bytes, 8 * list);
    const auto end = number_at<std::uint64_t>(first->bytes, 8 * list + 8);
    for (std::uint64_t i = begin; i < end; ++i) append_number(numbers, list);
  }
  rows.push_back({"row", 4, 1, numbers.size() / 8, numbers});
  for (const AnsweredColumn& column : columns) {
    if (column.name != "first" && column.name != "totals" && column.name != "invalid")
      rows.push_back(column);
  }
  columns = std::move(rows);
}

void append_cell(std::string& out, double number) { append_csv_number(out, number); }
void append_cell(std::string& out, float number) { append_csv_number(out, double{number}); }
void append_cell(std::string& out, std::int64_t number) { (out += std::to_string(number)) += ','; }
void append_cell(std::string& out, std::uint64_t number) { (out += std::to_string(number)) += ','; }
void append_cell(std::string& out, std::uint8_t number) { (out += std::to_string(number)) += ','; }

std::string encode_csv(const std::vector<AnsweredColumn>& columns) {
  std::string out;
  const auto end_line = [&] {
    if (!out.empty() && out.back() == ',') out.pop_back();
    out += "\r\n";
  };
  for (const AnsweredColumn& column : columns) {
    for (const std::string& name : part_names(column.name, column.width)) (out += name) += ',';
  }
  end_line();
  const std::uint64_t rows = columns.empty() ? 0 : columns[0].rows;
  for (std::uint64_t row = 0; row < rows; ++row) {
    for (const AnsweredColumn& column : columns) {
      for (std::uint64_t k = 0; k < column.width; ++k) {
        const std::size_t i = row * column.width + k;
        if (column.is_none(i)) {
          out += ',';
        } else {
          column.visit(i, [&](auto number) { append_cell(out, number); });
        }
      }
    }
    end_line();
  }
  return out;
}

std::string encode_npy(const std::vector<AnsweredColumn>& columns) {
  std::string type;
  for (const AnsweredColumn& column : columns) {
    type += (type.empty() ? "('" : ", ('") + column.name + "', " + column.numpy_type();
    if (column.width != 1) type += ", (" + std::to_string(column.width) + ",)";
    type += ")";
  }
  const std::uint64_t rows = columns.empty() ? 0 : columns[0].rows;
  std::string out = npy_head("[" + type + "]", std::to_string(rows) + ",");
  for (std::uint64_t row = 0; row < rows; ++row) {
    for (const AnsweredColumn& column : columns) {
      for (std::uint64_t k = 0; k < column.width; ++k)
        column.visit(row * column.width + k, [&](auto number) { append_number(out, number); });
    }
  }
  return out;
}

std::string encode_npz(const std::vector<AnsweredColumn>& columns) {
  ZipArchive archive;
  for (const AnsweredColumn& column : columns) {
    std::string file =
        npy_head(column.numpy_type(),
                 std::to_string(column.rows) + "," +
                     (column.width != 1 ? std::to_string(column.width) : std::string()));
    if (column.type == 2) {
      for (std::uint64_t i = 0; i < column.rows * column.width; ++i)
        column.visit(i, [&](auto number) { append_number(file, number); });
    } else {
      file += column.bytes;
    }
    archive.add(column.name + ".npy", file);
  }
  return archive.take();
}

}  // namespace

std::uint64_t bytes_of_column_table(std::string_view answer) {
  constexpr std::uint64_t kCells[] = {0, 26, 12, 4, 21, 21, 26};
  std::uint64_t bytes = 0, rows = 0;
  for (const AnsweredColumn& column : columns_of(answer)) {
    bytes += column.rows * column.width * kCells[column.type] + 64 * std::uint64_t{column.width};
    rows = std::max(rows, column.rows);
  }
  // The numbers of lists, once as they are and once as text.
  return bytes + 32 * rows;
}

Result<std::string> encode_column_table(TableFormat format, std::string_view answer) {
  std::vector<AnsweredColumn> columns = columns_of(answer);
  if (format == TableFormat::kNpz) {
    // Ids take twice as many bytes.
    if (answer.size() > kNpzBytes / 2) {
      return Error{ErrorKind::kTooLarge, "REQUEST_TOO_LARGE",
                   "an .npz file has at most 4 GiB; ask for fewer rows or fields, or for .npy", ""};
    }
    return encode_npz(columns);
  }
  std::string numbers;
  number_lists(columns, numbers);
  return format == TableFormat::kNpy ? encode_npy(columns) : encode_csv(columns);
}

}  // namespace sightline
