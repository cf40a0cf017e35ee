#pragma once
/// Reads requests of columns as bytes, in the layout of docs/reference/binary.md. For files of this
/// room only.

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/column.h"
#include "core/base/result.h"

namespace sightline {

/// The properties of a kind of request; its texts are literals.
struct BinaryKind {
  std::string_view magic;  ///< four bytes
  std::string_view noun;   ///< what a row is, for messages: "rays"
  /// Code of the error for too many rows.
  std::string_view too_many_code;
  std::uint32_t known_flags = 1;  ///< flags that are accepted; flag 1: numbers are float64
  /// Returns the number of columns that a request with these flags has.
  std::size_t (*columns)(std::uint32_t flags) = nullptr;
};

/// The header of a request.
struct BinaryHeader {
  static constexpr std::size_t kBytes = 24;     ///< size of the header
  static constexpr std::uint32_t kFloat64 = 1;  ///< flag: numbers are float64, else float32

  std::uint32_t flags = 0;
  std::uint64_t rows = 0;           ///< numbers in each column
  std::uint32_t options_bytes = 0;  ///< size of the options after the header

  /// Bytes of one number of the columns.
  std::size_t number_bytes() const { return (flags & kFloat64) != 0 ? 8 : 4; }
  /// The offset of the first column in the body.
  std::size_t columns_at() const { return (kBytes + std::size_t{options_bytes} + 7) / 8 * 8; }
};

/// Reads the header. `begin` is the body, or its first BinaryHeader::kBytes bytes or more. Errors:
/// BINARY_MALFORMED, also for fewer bytes; the kind's too_many_code if there are more than
/// max_rows.
Result<BinaryHeader> read_binary_header(std::string_view begin, const BinaryKind& kind,
                                        std::size_t max_rows);
/// Reads the header of a complete body, and checks that the body has the length that the header
/// states. Errors: those of read_binary_header.
Result<BinaryHeader> read_whole_header(std::string_view body, const BinaryKind& kind,
                                       std::size_t max_rows);
/// The options of a body, as JSON text; "{}" if it has none. Precondition: read_whole_header has
/// returned `header` for this body.
std::string options_of(std::string_view body, const BinaryHeader& header);
/// Reads column number `which`, from 0, into `column`, whose size is the number of rows.
/// Precondition: read_whole_header has returned `header` for this body.
void read_column(std::string_view body, const BinaryHeader& header, std::size_t which,
                 UnsetColumn<double>& column);

}  // namespace sightline

// Tests: tests/unit/proto/ray_binary_test.cpp
