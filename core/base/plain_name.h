#pragma once
/// is_plain_name: names that are safe in a URL, a header, a log and as a file name.

#include <algorithm>
#include <string_view>

namespace sightline {

/// True for 1 to 128 characters of A-Z a-z 0-9 . _ - that do not begin with a dot.
constexpr bool is_plain_name(std::string_view name) {
  if (name.empty() || name.size() > 128 || name.front() == '.') return false;
  // Written out: isalnum depends on the locale.
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

}  // namespace sightline

// Tests: tests/unit/server/http_server_test.cpp
