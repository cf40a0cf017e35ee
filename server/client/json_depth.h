#pragma once
/// Checks the nesting of JSON from a server or an agent before a document is built from it.

#include <string_view>

namespace sightline {

/// True if JSON is nested deeper than 64 levels, which no request or answer here needs. Printing
/// deeper JSON could exhaust the stack. The result for text that is not JSON is unspecified.
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

// Tests: tests/integration/mcp_test.py
