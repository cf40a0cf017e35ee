#pragma once
/// JsonPointer [RFC6901]: the place of an error in a client's body.

#include <cstddef>
#include <string>
#include <string_view>

namespace sightline {

/// Builds a pointer: JsonPointer().key("rays").index(17).key("direction").text() is
/// "/rays/17/direction".
class JsonPointer {
 public:
  /// Appends a member. `name` is any text; '~' and '/' are escaped. A name above 128 bytes is cut
  /// at a character, so that a hostile key does not become a huge answer.
  JsonPointer& key(std::string_view name);
  /// Appends an element of an array.
  JsonPointer& index(std::size_t number);
  /// The pointer so far; "" is the whole document.
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// The first `bytes` bytes of UTF-8 text, or fewer if a character would be cut; a part of the
/// memory of `text`.
std::string_view cut_utf8(std::string_view text, std::size_t bytes);

}  // namespace sightline

// Tests: tests/unit/proto/json_reader_test.cpp
