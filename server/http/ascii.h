#pragma once
/// Letters, digits and blanks of ASCII, as protocols define them, independent of the locale.

#include <algorithm>
#include <string>
#include <string_view>

namespace sightline {

/// Turns A to Z into a to z; other bytes stay.
constexpr char lower_case(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return lower_case(c); });
  return lower;
}

/// Compares without regard to the case of `text`. Precondition: `lower` has no capital letters.
constexpr bool equals_caseless(std::string_view text, std::string_view lower) {
  return text == lower || std::equal(text.begin(), text.end(), lower.begin(), lower.end(),
                                     [](char a, char b) { return lower_case(a) == b; });
}

/// The text without spaces and tabs at its ends; a part of the memory of `text`.
constexpr std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// The value of a hexadecimal digit; -1 if c is not one.
constexpr int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char lower = lower_case(c);
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/// Decodes percent sequences. Returns false if a percent sign is not followed by two hexadecimal
/// digits.
inline bool decode_percent(std::string_view text, std::string& decoded) {
  const std::size_t first = std::min(text.find('%'), text.size());
  decoded = text.substr(0, first);
  for (std::size_t i = first; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    if (i + 2 >= text.size()) return false;
    const int high = hex_value(text[i + 1]), low = hex_value(text[i + 2]);
    if (high < 0 || low < 0) return false;
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return true;
}

}  // namespace sightline

// Tests: tests/unit/server/request_head_test.cpp
