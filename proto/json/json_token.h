#pragma once
/// Classifies single tokens of JSON text, for error messages.

#include <string_view>

namespace sightline {

/// The kind of a token, for messages: "a string" in "found a string".
std::string_view token_kind(std::string_view token);

/// The token without white space at its end.
std::string_view trim(std::string_view token);

/// True if the text is a number by RFC 8259, section 6: [ "-" ] int [ frac ] [ exp ].
bool is_json_number(std::string_view text);

/// True if a JSON value can begin with this token.
bool looks_like_json(std::string_view token);

/// True if the text is a common spelling of NaN or infinity, which JSON does not have.
bool is_non_finite_word(std::string_view text);

}  // namespace sightline

// Tests: tests/unit/proto/json_reader_test.cpp
