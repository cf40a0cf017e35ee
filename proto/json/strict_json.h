#pragma once
/// Small JSON documents of which nothing may be strange. For files of this room only.

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// Errors: JSON_MALFORMED, KEY_DUPLICATE.
Result<nlohmann::json> parse_strictly(std::string_view body);

/// kInvalid at that JSON pointer.
Error fault(const char* code, std::string message, std::string pointer);
/// The pointer of a member of what is at `place`.
std::string below(const std::string& place, std::string_view key);
/// An object that has no other keys than these. Errors: TYPE_WRONG, KEY_UNKNOWN.
Status check_object(const nlohmann::json& value, const std::string& place,
                    std::initializer_list<std::string_view> known);

}  // namespace sightline

// Tests: tests/unit/proto/load_json_test.cpp
