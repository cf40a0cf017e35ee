#pragma once
/// How a fuzz target says that a promise was broken.

#include <cstdio>
#include <cstdlib>

namespace sightline::fuzz {

inline void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

}  // namespace sightline::fuzz
