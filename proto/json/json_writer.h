#pragma once
/// JsonWriter: appends JSON text to a buffer that grows by doubling. No allocation per number.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace sightline {

/// Writes one text: construct, append, take(). It does not check the structure: the caller writes
/// brackets and commas. All functions may throw std::bad_alloc. Not thread-safe.
class JsonWriter {
 public:
  /// expected_bytes  an estimate of the size; a wrong one only costs a copy
  explicit JsonWriter(std::size_t expected_bytes);

  /// Appends text that is JSON already: keys, brackets, commas.
  void raw(std::string_view text) {
    std::memcpy(room(text.size()), text.data(), text.size());
    size_ += text.size();
  }
  void raw(char c) {
    *room(1) = c;
    ++size_;
  }
  /// Appends a number as write_json_number does.
  void number(double value);
  void number(std::uint64_t value);
  void number(std::uint32_t value) { number(std::uint64_t{value}); }
  /// Appends "[x,y,z]".
  void vector(double x, double y, double z);
  void boolean(bool value) { raw(value ? std::string_view("true") : std::string_view("false")); }
  /// Appends a quoted string. Bytes that are not UTF-8 become U+FFFD.
  void string(std::string_view text);
  /// Appends a string, or null if it is empty: a name that the file does not have.
  void name(std::string_view text) { text.empty() ? raw("null") : string(text); }

  /// For writing many values directly: returns a pointer to at least `bytes` writable bytes, valid
  /// until the next call. written_to() must then be called with the end of what was written.
  char* room(std::size_t bytes) {
    if (buffer_.size() - size_ < bytes) grow(size_ + bytes);
    return buffer_.data() + size_;
  }
  void written_to(const char* end) { size_ = static_cast<std::size_t>(end - buffer_.data()); }

  /// Bytes of the text so far.
  std::size_t size() const { return size_; }
  /// Returns the text; the writer is empty afterwards.
  std::string take();

 private:
  void grow(std::size_t bytes);

  std::string buffer_;  ///< its size is the allocated room; size_ is the size of the text
  std::size_t size_ = 0;
};

}  // namespace sightline
