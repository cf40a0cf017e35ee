#pragma once
/// A request of columns as bytes, as docs/reference/binary.md lays it out. For files of this room
/// only.

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/column.h"
#include "core/base/result.h"

namespace sightline {

/// The layout of a kind of request.
struct BinaryKind {
  std::string_view magic;  ///< four bytes
  std::string_view noun;   ///< "rays"
  std::string_view too_many_code;
  std::uint32_t known_flags = 1;  ///< of which 1 says that numbers are float64
  /// How many columns there are with these flags.
  std::size_t (*columns)(std::uint32_t flags) = nullptr;
};

struct BinaryHeader {
  static constexpr std::size_t kBytes = 24;
  static constexpr std::uint32_t kFloat64 = 1;

  std::uint32_t flags = 0;
  std::uint64_t rows = 0;
  std::uint32_t options_bytes = 0;

  std::size_t number_bytes() const { return (flags & kFloat64) != 0 ? 8 : 4; }
  /// The offset of the first column.
  std::size_t columns_at() const { return (kBytes + std::size_t{options_bytes} + 7) / 8 * 8; }
};

/// Errors: BINARY_MALFORMED, the kind's too_many_code. `begin` may be more than the header.
Result<BinaryHeader> read_binary_header(std::string_view begin, const BinaryKind& kind,
                                        std::size_t max_rows);
/// The header of a whole body, whose length must be what it says.
Result<BinaryHeader> read_whole_header(std::string_view body, const BinaryKind& kind,
                                       std::size_t max_rows);
/// The options of a body as JSON.
std::string options_of(std::string_view body, const BinaryHeader& header);
/// Column number `which` of the rows; `column` has their number. Precondition: the header is that
/// of the whole body.
void read_column(std::string_view body, const BinaryHeader& header, std::size_t which,
                 UnsetColumn<double>& column);

}  // namespace sightline

// Tests: tests/unit/proto/ray_binary_test.cpp
