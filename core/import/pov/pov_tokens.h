#pragma once
/// Splits a POV-Ray file into tokens: names, numbers, strings and single characters; comments are
/// skipped.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline::pov {

/// The kind of a token. kName: a letter or "_", then letters, digits and "_". kSign: one character
/// that begins no other kind, such as "{" or "-". kEnd: the end of the text.
enum class TokenKind : std::uint8_t { kName, kNumber, kString, kSign, kEnd };

/// A token, as a part of the file's text.
struct Token {
  TokenKind kind = TokenKind::kEnd;
  std::string_view text;  ///< of a string with its quotes; empty for kEnd
  double number = 0;      ///< value of kNumber; a sign before it is a token of its own
  std::size_t line = 1;   ///< where the token begins, from 1

  /// True if this is not a string and its text is `wanted`.
  bool is(std::string_view wanted) const { return kind != TokenKind::kString && text == wanted; }
};

/// Reads tokens one after the other: next() until kEnd. The text must outlive this object and its
/// tokens.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) {}

  /// Returns the next token; kEnd at the end. Errors: POV_SYNTAX_INVALID for a comment or string
  /// without an end, and for a number beyond float64. No call may follow an error.
  Result<Token> next();
  /// The text of the file from the start of `first` up to the start of `last`. Precondition: both
  /// are tokens of this object, in this order.
  std::string_view between(const Token& first, const Token& last) const;

 private:
  Status skip_blanks();

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

/// The error POV_SYNTAX_INVALID with `what`, naming the line.
Error broken(std::size_t line, const std::string& what);

}  // namespace sightline::pov

// Tests: tests/unit/import/pov_scene_test.cpp
