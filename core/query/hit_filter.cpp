#include "core/query/hit_filter.h"

namespace sightline {

namespace {

/// Bytes of the character that begins here.
std::size_t character_size(std::string_view text, std::size_t at) {
  std::size_t end = at + 1;
  while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0u) == 0x80u) ++end;
  return end - at;
}

}  // namespace

bool glob_matches(std::string_view pattern, std::string_view text, DeadlineWatch& watch) {
  // After a mismatch only the last star is tried again, one character later: earlier ones cannot
  // help, so the cost is at most the product of the lengths.
  constexpr std::size_t kNoStar = std::string_view::npos;
  std::size_t p = 0, t = 0, star = kNoStar, star_text = 0;
  while (t < text.size()) {
    if (watch.passed()) return false;
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      star_text = t;
    } else if (p < pattern.size() && pattern[p] == '?') {
      ++p;
      t += character_size(text, t);
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != kNoStar) {
      p = star + 1;
      star_text += character_size(text, star_text);
      t = star_text;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

}  // namespace sightline
