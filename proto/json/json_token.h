#pragma once
/// Classifies and places single tokens of JSON text, for error messages. A token is a bracket, a string, or a
/// text without brackets, commas and white space, such as a number or "true". A parser finds it.

#include <cstddef>
#include <string>
#include <string_view>

namespace sightline {

/// The kind of a token by its first character, for messages: "a string" in "found a string". The
/// result is a literal.
std::string_view token_kind(std::string_view token);

/// The token without white space at its end; a part of the memory of `token`.
std::string_view trim(std::string_view token);

/// True if the text is a number by RFC 8259, section 6: [ "-" ] int [ frac ] [ exp ].
bool is_json_number(std::string_view text);

/// True if a JSON value can begin with this token: it begins like a string, an object or an array,
/// or is true, false, null or a number.
bool looks_like_json(std::string_view token);

/// True if the text is "nan", "inf" or "infinity", in any case and with or without a sign. JSON has
/// none of them.
bool is_non_finite_word(std::string_view text);

/// "; near line L, column C" of the byte `at` of a text, both from 1. A column counts bytes. `at` may
/// exceed the size.
std::string near_line(std::string_view text, std::size_t at);

}  // namespace sightline

// Tests: tests/unit/proto/json_reader_test.cpp
