#pragma once
/// Single tokens of JSON text, to say what stands where something else was expected.

#include <string_view>

namespace sightline {

/// A name for the kind of a token, for messages: "found a string".
std::string_view token_kind(std::string_view token);

/// Without the white space at its end.
std::string_view trim(std::string_view token);

/// number = [ "-" ] int [ frac ] [ exp ], RFC 8259 section 6.
bool is_json_number(std::string_view text);

/// Whether a value of JSON begins with this token.
bool looks_like_json(std::string_view token);

/// The ways in which programs write what JSON cannot say.
bool is_non_finite_word(std::string_view text);

}  // namespace sightline

// Tests: tests/unit/proto/json_reader_test.cpp
