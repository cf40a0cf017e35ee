#include "core/import/pov/pov_tokens.h"

#include <algorithm>
#include <charconv>

#include "core/import/input/refusal.h"

namespace sightline::pov {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

}  // namespace

Error broken(std::size_t line, const std::string& what) {
  return gltf::malformed("POV_SYNTAX_INVALID", "line " + std::to_string(line) + ": " + what);
}

Status Tokens::skip_blanks() {
  const auto starts = [&](const char* sign) { return text_.compare(at_, 2, sign) == 0; };
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (c == '\n') ++line_;
    if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
      ++at_;
    } else if (starts("//")) {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (starts("/*")) {
      // POV-Ray's comments nest.
      const std::size_t first_line = line_;
      std::size_t depth = 0;
      do {
        if (at_ >= text_.size()) return broken(first_line, "a comment has no end");
        const bool opens = starts("/*"), closes = starts("*/");
        if (text_[at_] == '\n') ++line_;
        depth = depth + (opens ? 1 : 0) - (closes ? 1 : 0);
        at_ += opens || closes ? 2u : 1u;
      } while (depth > 0);
    } else {
      break;
    }
  }
  return success();
}

Result<Token> Tokens::next() {
  if (Status status = skip_blanks(); !status) return status.error();
  Token token;
  token.line = line_;
  const std::size_t begin = at_;
  if (begin == text_.size()) {
    token.text = text_.substr(begin);
    return token;
  }
  const char c = text_[begin];
  const char after = begin + 1 < text_.size() ? text_[begin + 1] : ' ';
  if (is_letter(c)) {
    token.kind = TokenKind::kName;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
  } else if (is_digit(c) || (c == '.' && is_digit(after))) {
    token.kind = TokenKind::kNumber;
    const char* const end = text_.data() + text_.size();
    const auto [stop, failure] = std::from_chars(text_.data() + begin, end, token.number);
    if (failure != std::errc()) return broken(line_, "a number is beyond float64");
    at_ = static_cast<std::size_t>(stop - text_.data());
  } else if (c == '"') {
    token.kind = TokenKind::kString;
    do {
      at_ += text_[at_] == '\\' ? 2u : 1u;
      if (at_ >= text_.size() || text_[at_] == '\n') return broken(line_, "a string has no end");
    } while (text_[at_] != '"');
    ++at_;
  } else {
    token.kind = TokenKind::kSign;
    ++at_;
  }
  token.text = text_.substr(begin, at_ - begin);
  return token;
}

std::string_view Tokens::between(const Token& first, const Token& last) const {
  const auto from = static_cast<std::size_t>(first.text.data() - text_.data());
  const auto to = static_cast<std::size_t>(last.text.data() - text_.data());
  return text_.substr(from, to - from);
}

}  // namespace sightline::pov
