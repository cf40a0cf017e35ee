#pragma once
/// Names of vertex attributes that are no part of glTF, but of the application that wrote the file
/// [glTF2] 3.7.2.1: "_TEMPERATURE".

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace sightline {

/// The most bytes of a name.
inline constexpr std::size_t kLongestAttributeName = 64;
/// The most names that one request may have as fields.
inline constexpr std::size_t kMostNamedFields = 16;

/// True if hits may have a field of this name: `_` and at least one more ASCII letter, digit or
/// character of "_.:-". So no format of answers has to escape it.
constexpr bool is_attribute_name(std::string_view name) {
  const auto is_plain = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '.' || c == ':' || c == '-';
  };
  return name.size() >= 2 && name.size() <= kLongestAttributeName && name[0] == '_' &&
         std::all_of(name.begin(), name.end(), is_plain);
}

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
