#pragma once
/// JSON of the other side, before anything is built from it.

#include <string_view>

namespace sightline {

/// Deeper than any question or answer here; what is deeper could exhaust the stack of whoever
/// prints it again. Of what is no JSON it says either.
inline bool is_nested_deeply(std::string_view text) {
  constexpr int kDeepest = 64;
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepest) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

}  // namespace sightline
