#pragma once
/// BinaryAnswer: writes an answer of columns as bytes, in the layout of docs/reference/binary.md.
/// For files of this room only.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// Writes columns after a table of them. All columns are announced first; then begin(), then next()
/// for each column in that order, then take(), once each. So the memory of an answer is allocated
/// once. A number is a double, float, std::int64_t, or an unsigned integer of 8, 32 or 64 bits.
class BinaryAnswer {
 public:
  static constexpr std::size_t kLongestName = 16;  ///< bytes of the name of a column
  /// Announces a column of `rows` values of `width` numbers each. `name` has at most kLongestName
  /// bytes, and must be valid until begin().
  template <class Number>
  void announce(std::string_view name, std::size_t rows, std::uint32_t width = 1) {
    entries_.push_back({name, type_of(Number{}), sizeof(Number), width, rows});
  }
  /// Writes the table. After this, next() is called for each column in the order of the
  /// announcements.
  void begin();
  /// Writes the next column from value(row, component), each converted to Number. Precondition: the
  /// column was announced with this type.
  template <class Number, class Value>
  void next(Value value) {
    const Entry& entry = begin_next();
    text_.resize(entry.at + entry.bytes());
    char* at = text_.data() + entry.at;
    for (std::size_t row = 0; row < entry.rows; ++row) {
      for (std::uint32_t k = 0; k < entry.width; ++k) {
        const auto number = static_cast<Number>(value(row, k));
        std::memcpy(at, &number, sizeof number);
        at += sizeof number;
      }
    }
  }
  /// Writes the next column from an array. Precondition: it was announced with this type and this
  /// number of numbers.
  template <class Number>
  void next(std::span<const Number> column) {
    begin_next();
    text_.append(reinterpret_cast<const char*>(column.data()), column.size_bytes());
  }
  /// Returns the bytes. Precondition: all columns were written.
  std::string take();

 private:
  struct Entry {
    std::string_view name;
    std::uint32_t type;
    std::size_t number_bytes;
    std::uint32_t width;
    std::size_t rows;
    /// Offset of the column in the answer.
    std::size_t at = 0;

    std::size_t bytes() const { return rows * width * number_bytes; }
  };
  static constexpr std::uint32_t type_of(double) { return 1; }
  static constexpr std::uint32_t type_of(std::uint32_t) { return 2; }
  static constexpr std::uint32_t type_of(std::uint8_t) { return 3; }
  static constexpr std::uint32_t type_of(std::uint64_t) { return 4; }
  static constexpr std::uint32_t type_of(std::int64_t) { return 5; }
  static constexpr std::uint32_t type_of(float) { return 6; }

  /// Pads with zeros up to the beginning of the next column.
  const Entry& begin_next() {
    text_.resize(entries_[next_].at);
    return entries_[next_++];
  }
  template <class Number>
  void write(std::size_t at, Number number) {
    std::memcpy(text_.data() + at, &number, sizeof(Number));
  }

  std::vector<Entry> entries_;
  std::size_t next_ = 0, size_ = 0;
  std::string text_;
};

}  // namespace sightline

// Tests: tests/unit/proto/ray_binary_test.cpp
