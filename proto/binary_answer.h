#pragma once
/// An answer of columns as bytes, as proto/BINARY.md lays it out. For files of this room only.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// Collects columns, then writes them behind their table. The memory of an answer is its bytes
/// once: columns are announced first and filled in place.
class BinaryAnswer {
 public:
  template <class Number>
  void announce(std::string_view name, std::size_t rows, std::uint32_t width = 1) {
    entries_.push_back({name, type_of(Number{}), sizeof(Number), width, rows});
  }
  /// After this, `next` in the order of the announcements.
  void begin();
  /// value(row, component) of the next column.
  template <class Number, class Value>
  void next(Value value) {
    const Entry& entry = entries_[next_++];
    char* at = text_.data() + entry.at;
    for (std::size_t row = 0; row < entry.rows; ++row) {
      for (std::uint32_t k = 0; k < entry.width; ++k) {
        const auto number = static_cast<Number>(value(row, k));
        std::memcpy(at, &number, sizeof number);
        at += sizeof number;
      }
    }
  }
  /// The next column as it stands. Precondition: it was announced as one of these numbers.
  template <class Number>
  void next(std::span<const Number> column) {
    const Entry& entry = entries_[next_++];
    if (!column.empty()) std::memcpy(text_.data() + entry.at, column.data(), column.size_bytes());
  }
  std::string take() { return std::move(text_); }

 private:
  struct Entry {
    std::string_view name;
    std::uint32_t type;
    std::size_t number_bytes;
    std::uint32_t width;
    std::size_t rows;
    std::size_t at = 0;
  };
  static constexpr std::uint32_t type_of(double) { return 1; }
  static constexpr std::uint32_t type_of(std::uint32_t) { return 2; }
  static constexpr std::uint32_t type_of(std::uint8_t) { return 3; }
  static constexpr std::uint32_t type_of(std::uint64_t) { return 4; }
  static constexpr std::uint32_t type_of(std::int64_t) { return 5; }

  template <class Number>
  void write(std::size_t at, Number number) {
    std::memcpy(text_.data() + at, &number, sizeof(Number));
  }

  std::vector<Entry> entries_;
  std::size_t next_ = 0;
  std::string text_;
};

}  // namespace sightline
