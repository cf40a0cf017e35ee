#pragma once
/// JSON pointers [RFC6901]: the place of a fault in a client's body.

#include <cstddef>
#include <string>
#include <string_view>

namespace sightline {

/// "/rays/17/direction" is JsonPointer().key("rays").index(17).key("direction").text().
class JsonPointer {
 public:
  /// `name` is any text; '~' and '/' are escaped. Names longer than 128 bytes are cut at a
  /// character, so that a hostile key does not become a huge answer.
  JsonPointer& key(std::string_view name);
  JsonPointer& index(std::size_t number);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// The first `bytes` bytes of UTF-8 text, cut before a character that would not fit whole.
std::string_view cut_utf8(std::string_view text, std::size_t bytes);

}  // namespace sightline

// Tests: tests/unit/proto/json_reader_test.cpp
