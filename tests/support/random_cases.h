#pragma once
/// How many of its random cases a test runs.

#include <cstdlib>

#include "core/base/sanitizers.h"

namespace sightline::test {

/// All of them; an eighth under a sanitizer, which looks at every step and not at every number, and
/// takes ten times as long: also of what is expected to occur among them. SIGHTLINE_ALL_CASES=1 in
/// the environment is all everywhere; SIGHTLINE_TIMES_CASES=50 is 50 times as many.
template <class Count>
Count random_cases(Count all) {
  if (const char* times = std::getenv("SIGHTLINE_TIMES_CASES"); times != nullptr)
    return all * static_cast<Count>(std::atoi(times));
#if defined(SIGHTLINE_WATCHED_HEAP)
  if (std::getenv("SIGHTLINE_ALL_CASES") == nullptr) return (all + 7) / 8;
#endif
  return all;
}

}  // namespace sightline::test
