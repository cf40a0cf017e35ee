#pragma once
/// Appends JSON text to one buffer that grows by doubling; nothing is allocated per number.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace sightline {

class JsonWriter {
 public:
  /// expected_bytes  a guess; a wrong one costs a copy, not an answer.
  explicit JsonWriter(std::size_t expected_bytes);

  /// Text that is JSON already: keys, brackets, commas.
  void raw(std::string_view text) {
    std::memcpy(room(text.size()), text.data(), text.size());
    size_ += text.size();
  }
  void raw(char c) {
    *room(1) = c;
    ++size_;
  }
  /// Writes a number as write_json_number does.
  void number(double value);
  void number(std::uint64_t value);
  void number(std::uint32_t value) { number(std::uint64_t{value}); }
  /// "[x,y,z]".
  void vector(double x, double y, double z);
  void boolean(bool value) { raw(value ? std::string_view("true") : std::string_view("false")); }
  /// A quoted string; bytes that are not UTF-8 become U+FFFD.
  void string(std::string_view text);
  /// Writes a string, or null for an empty one: a name that the file does not give.
  void name(std::string_view text) { text.empty() ? raw("null") : string(text); }

  /// For many values at once: so many bytes to write at, then where what was written ends.
  char* room(std::size_t bytes) {
    if (buffer_.size() - size_ < bytes) grow(size_ + bytes);
    return buffer_.data() + size_;
  }
  void written_to(const char* end) { size_ = static_cast<std::size_t>(end - buffer_.data()); }

  std::size_t size() const { return size_; }
  /// The text written so far; the writer is empty afterwards.
  std::string take();

 private:
  void grow(std::size_t bytes);

  std::string buffer_;  ///< its size is the room that was made ready, not what was written
  std::size_t size_ = 0;
};

}  // namespace sightline
