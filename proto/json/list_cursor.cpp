#include "proto/json/list_cursor.h"

#include <charconv>

namespace sightline {
namespace {

constexpr std::size_t kDigits = 16;

void append_hex(std::uint64_t value, std::string& text) {
  for (int shift = 60; shift >= 0; shift -= 4) text += "0123456789abcdef"[value >> shift & 15];
}

bool read_hex(std::string_view text, std::uint64_t& value) {
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value, 16);
  return error == std::errc() && at == end;
}

}  // namespace

std::string encode_cursor(const ListCursor& cursor) {
  std::string text;
  append_hex(cursor.revision, text);
  append_hex(cursor.question, text);
  text += cursor.of_nodes ? 'n' : 't';
  append_hex(cursor.from, text);
  return text;
}

std::optional<ListCursor> decode_cursor(std::string_view text) {
  ListCursor cursor;
  if (text.size() != 3 * kDigits + 1 || !read_hex(text.substr(0, kDigits), cursor.revision) ||
      !read_hex(text.substr(kDigits, kDigits), cursor.question) ||
      !read_hex(text.substr(2 * kDigits + 1), cursor.from) || cursor.from == 0) {
    return std::nullopt;
  }
  cursor.of_nodes = text[2 * kDigits] == 'n';
  // What is spelled otherwise was not made here.
  if (encode_cursor(cursor) != text) return std::nullopt;
  return cursor;
}

}  // namespace sightline
