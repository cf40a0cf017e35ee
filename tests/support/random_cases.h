#pragma once
/// How many of its random cases a test runs.

#include <cstdlib>

#include "core/base/sanitizers.h"

namespace sightline::test {

/// All of them; an eighth under a sanitizer, which looks at every step and not at every number, and
/// takes ten times as long: also of what is expected to occur among them. SIGHTLINE_ALL_CASES=1 in
/// the environment is all everywhere.
template <class Count>
Count random_cases(Count all) {
#if defined(SIGHTLINE_WATCHED_HEAP)
  if (std::getenv("SIGHTLINE_ALL_CASES") == nullptr) return (all + 7) / 8;
#endif
  return all;
}

}  // namespace sightline::test
