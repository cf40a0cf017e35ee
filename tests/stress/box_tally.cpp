#include "tests/stress/box_tally.h"

#include <algorithm>

#include "tests/contestants/overlap_tests.h"
#include "tests/contestants/slab_tests.h"

namespace sightline::stress {

namespace {

constexpr std::size_t kFailuresKept = 3;

bool answer_of(const contestants::SlabTest& peer, const RayBoxCase& test) {
  return peer.test(test.ray, test.aligned).hit;
}
bool answer_of(const contestants::OverlapTest& peer, const TriangleBoxCase& test) {
  return peer.test(test.triangle, test.aligned);
}

bool meets(const RayBoxVerdict& verdict) { return verdict.hit; }
bool meets(const TriangleBoxVerdict& verdict) { return verdict.meets; }

/// That a triangle without area meets nothing is this house's rule, not the literature's.
bool peers_know(const RayBoxCase& test, const RayBoxVerdict&) { return !test.oriented; }
bool peers_know(const TriangleBoxCase& test, const TriangleBoxVerdict& verdict) {
  return !test.oriented && !verdict.no_area;
}

std::vector<RayBoxDifference> differences(const std::vector<RayBoxCase>& tests) {
  return differing_kernels(tests);
}
/// There is one way to ask about a triangle and a box.
std::vector<RayBoxDifference> differences(const std::vector<TriangleBoxCase>&) { return {}; }

template <class Family, class Peers>
BoxTally judge_with(const Family& family, std::uint64_t seed, std::uint64_t count,
                    const Peers& peers) {
  BoxTally tally;
  for (const auto& peer : peers) tally.peers.push_back({std::string(peer.name), 0, 0, 0});
  oracle::Random random(seed);
  const auto fail = [&](std::uint64_t number, const std::string& fault, const auto& test) {
    ++tally.wrong;
    if (tally.failures.size() >= kFailuresKept) return;
    tally.failures.push_back(std::string(family.name) + " seed " + std::to_string(seed) + " case " +
                             std::to_string(number) + ": " + fault + "\n  " + describe(test));
  };
  std::vector<decltype(family.make(random))> tests;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto& test = tests.emplace_back(family.make(random));
    const auto verdict = judge(test);
    ++tally.judged;
    tally.oriented += test.oriented ? 1u : 0u;
    tally.meet += meets(verdict) ? 1u : 0u;
    tally.touching += verdict.touching ? 1u : 0u;
    if (!verdict.fault.empty()) fail(i, verdict.fault, test);
    if (!peers_know(test, verdict)) continue;
    for (std::size_t p = 0; p < peers.size(); ++p) {
      const bool answer = answer_of(peers[p], test);
      ++tally.peers[p].asked;
      tally.peers[p].false_hits += answer && !meets(verdict) ? 1u : 0u;
      tally.peers[p].false_misses += !answer && meets(verdict) ? 1u : 0u;
    }
  }
  for (const RayBoxDifference& found : differences(tests)) {
    fail(found.number, found.fault, tests[found.number]);
  }
  return tally;
}

}  // namespace

void BoxTally::add(const BoxTally& other) {
  judged += other.judged;
  oriented += other.oriented;
  meet += other.meet;
  touching += other.touching;
  wrong += other.wrong;
  if (peers.empty()) {
    peers = other.peers;
  } else {
    for (std::size_t p = 0; p < other.peers.size(); ++p) {
      peers[p].asked += other.peers[p].asked;
      peers[p].false_hits += other.peers[p].false_hits;
      peers[p].false_misses += other.peers[p].false_misses;
    }
  }
  for (const std::string& failure : other.failures) {
    if (failures.size() < kFailuresKept) failures.push_back(failure);
  }
}

BoxTally judge_pairs(const RayBoxFamily& family, std::uint64_t seed, std::uint64_t count) {
  return judge_with(family, seed, count, contestants::slab_tests());
}

BoxTally judge_pairs(const TriangleBoxFamily& family, std::uint64_t seed, std::uint64_t count) {
  return judge_with(family, seed, count, contestants::overlap_tests());
}

}  // namespace sightline::stress
