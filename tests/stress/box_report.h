#pragma once
/// The table of a run of box pairs, for people and for machines.

#include <string>
#include <vector>

#include "tests/stress/box_tally.h"

namespace sightline::stress {

struct BoxFamilyResult {
  std::string family;
  BoxTally tally;
};

struct BoxRun {
  std::uint64_t seed = 0;
  unsigned threads = 0;
  double cpu_minutes = 0;
  std::vector<BoxFamilyResult> rays, triangles;
};

BoxTally total_of(const std::vector<BoxFamilyResult>& results);
std::string markdown(const BoxRun& run);
std::string json(const BoxRun& run);
/// "floor 5: ...". It holds for no fewer pairs than it asks for, a third of them touching.
std::string floor_line(const BoxRun& run);

}  // namespace sightline::stress
