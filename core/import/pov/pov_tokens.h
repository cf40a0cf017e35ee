#pragma once
/// The words of a POV-Ray file: names, numbers, strings, single signs; comments are skipped.

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
  double number = 0;  ///< of kNumber, without a sign
  std::size_t line = 1;

  bool is(std::string_view wanted) const { return kind != TokenKind::kString && text == wanted; }
};

class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) {}

  /// Errors: POV_SYNTAX_INVALID for a comment or string without end and for a number that is none
  /// or beyond float64.
  Result<Token> next();
  /// The text between two tokens of next(), as it is written.
  std::string_view between(const Token& first, const Token& last) const;

 private:
  Status skip_blanks();

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

Error broken(std::size_t line, const std::string& what);

}  // namespace sightline::pov

// Tests: tests/unit/import/pov_scene_test.cpp
