#include "proto/binary/binary_columns.h"

#include <bit>
#include <cstring>
#include <limits>

namespace sightline {
namespace {

static_assert(std::endian::native == std::endian::little, "columns are copied as they stand");

Error malformed(std::string message) {
  return {ErrorKind::kMalformed, "BINARY_MALFORMED", std::move(message), ""};
}

template <class T>
T read_at(std::string_view body, std::size_t at) {
  T value;
  std::memcpy(&value, body.data() + at, sizeof(T));
  return value;
}

void widen_numbers(std::string_view body, std::size_t at, UnsetColumn<double>& column) {
  for (std::size_t i = 0; i < column.size(); ++i) {
    column[i] = static_cast<double>(read_at<float>(body, at + i * sizeof(float)));
  }
}

}  // namespace

Result<BinaryHeader> read_binary_header(std::string_view begin, const BinaryKind& kind,
                                        std::size_t max_rows) {
  if (begin.size() < BinaryHeader::kBytes) {
    return malformed("the header has 24 bytes, the body " + std::to_string(begin.size()));
  }
  if (begin.substr(0, kind.magic.size()) != kind.magic) {
    return malformed("the body must begin with " + std::string(kind.magic));
  }
  BinaryHeader header;
  header.flags = read_at<std::uint32_t>(begin, 4);
  header.rows = read_at<std::uint64_t>(begin, 8);
  header.options_bytes = read_at<std::uint32_t>(begin, 16);
  if ((header.flags & ~kind.known_flags) != 0 || read_at<std::uint32_t>(begin, 20) != 0) {
    return malformed("bits of the header that have no meaning must be zero");
  }
  if (header.rows > max_rows) {
    return Error{ErrorKind::kTooLarge, std::string(kind.too_many_code),
                 "a request may hold " + std::to_string(max_rows) + " " + std::string(kind.noun) +
                     ", this has " + std::to_string(header.rows),
                 ""};
  }
  return header;
}

Result<BinaryHeader> read_whole_header(std::string_view body, const BinaryKind& kind,
                                       std::size_t max_rows) {
  auto header = read_binary_header(body, kind, max_rows);
  if (!header) return header;
  const std::size_t row = kind.columns(header->flags) * header->number_bytes();
  const std::size_t at = header->columns_at();
  if (header->rows > (std::numeric_limits<std::size_t>::max() - at) / row ||
      body.size() != at + header->rows * row) {
    return malformed("the header announces " + std::to_string(header->rows) + " " +
                     std::string(kind.noun) + " of " + std::to_string(row) + " bytes from byte " +
                     std::to_string(at) + " on, the body has " + std::to_string(body.size()) +
                     " bytes");
  }
  return header;
}

std::string options_of(std::string_view body, const BinaryHeader& header) {
  std::string options(body.substr(BinaryHeader::kBytes, header.options_bytes));
  return options.empty() ? "{}" : options;
}

void read_column(std::string_view body, const BinaryHeader& header, std::size_t which,
                 UnsetColumn<double>& column) {
  const std::size_t at = header.columns_at() + which * header.rows * header.number_bytes();
  if ((header.flags & BinaryHeader::kFloat64) != 0) {
    if (!column.empty())
      std::memcpy(column.data(), body.data() + at, column.size() * sizeof(double));
  } else {
    widen_numbers(body, at, column);
  }
}

}  // namespace sightline
