#pragma once
/// Splits a POV-Ray file into tokens: names, numbers, strings and single characters; comments are
/// skipped.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline::pov {

enum class TokenKind : std::uint8_t { kName, kNumber, kString, kSign, kEnd };

struct Token {
  TokenKind kind = TokenKind::kEnd;
  std::string_view text;
  double number = 0;  ///< value of kNumber, without a sign
  std::size_t line = 1;

  /// True if this is not a string and its text is `wanted`.
  bool is(std::string_view wanted) const { return kind != TokenKind::kString && text == wanted; }
};

/// Reads tokens one after the other. The text must outlive it.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) {}

  /// Returns the next token; kEnd at the end. Errors: POV_SYNTAX_INVALID for a comment or string
  /// without an end, and for an invalid number or one that exceeds float64.
  Result<Token> next();
  /// The text of the file from the start of `first` up to the start of `last`.
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
