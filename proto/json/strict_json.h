#pragma once
/// Parses small JSON documents strictly. For files of this room only.

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// Parses a body as JSON, without comments and duplicate keys. Errors: JSON_MALFORMED,
/// KEY_DUPLICATE.
Result<nlohmann::json> parse_strictly(std::string_view body);

/// An error of the kind kInvalid at a JSON pointer.
Error fault(const char* code, std::string message, std::string pointer);
/// The pointer of the member `key` of the value at `place`.
std::string below(const std::string& place, std::string_view key);
/// Checks that a value is an object with no other keys than `known`. `place` is its JSON pointer.
/// Errors: TYPE_WRONG, KEY_UNKNOWN.
Status check_object(const nlohmann::json& value, const std::string& place,
                    std::initializer_list<std::string_view> known);

}  // namespace sightline

// Tests: tests/unit/proto/load_json_test.cpp
