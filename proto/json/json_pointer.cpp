#include "proto/json/json_pointer.h"

namespace sightline {

std::string_view cut_utf8(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return text;
  // A continuation byte is 10xxxxxx: step back to the start of the character that would be split.
  while (bytes > 0 && (static_cast<unsigned char>(text[bytes]) & 0xc0u) == 0x80u) --bytes;
  return text.substr(0, bytes);
}

JsonPointer& JsonPointer::key(std::string_view name) {
  text_ += '/';
  for (const char c : cut_utf8(name, 128)) {
    if (c == '~') {
      text_ += "~0";
    } else if (c == '/') {
      text_ += "~1";
    } else {
      text_ += c;
    }
  }
  return *this;
}

JsonPointer& JsonPointer::index(std::size_t number) {
  text_ += '/';
  text_ += std::to_string(number);
  return *this;
}

}  // namespace sightline
