#pragma once
/// The table of a run, for people and for machines.

#include <string>
#include <vector>

#include "tests/stress/case.h"
#include "tests/stress/tally.h"

namespace sightline::stress {

struct FamilyResult {
  Family family;
  FamilyTally tally;
};

struct RunFacts {
  std::uint64_t seed = 0;
  double minutes = 0;
  std::vector<std::string> kernels;
};

std::string markdown(const std::vector<FamilyResult>& results, const RunFacts& facts);
std::string json(const std::vector<FamilyResult>& results, const RunFacts& facts);

}  // namespace sightline::stress
