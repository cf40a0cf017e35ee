#pragma once
/// What is counted of a family of pairs with a box, and a piece of such a family judged.

#include <cstdint>
#include <string>
#include <vector>

#include "tests/stress/ray_box_cases.h"
#include "tests/stress/triangle_box_cases.h"

namespace sightline::stress {

/// A test of the literature: only whether they meet is held against it.
struct BoxPeerTally {
  std::string name;
  std::uint64_t asked = 0;
  std::uint64_t false_hits = 0;
  std::uint64_t false_misses = 0;
};

struct BoxTally {
  std::uint64_t judged = 0;
  std::uint64_t oriented = 0;  ///< of them with an oriented box, of which the peers know nothing
  std::uint64_t meet = 0;
  std::uint64_t touching = 0;  ///< an equality decides
  std::uint64_t wrong = 0;     ///< Sightline, any field of its answer
  std::vector<BoxPeerTally> peers;
  std::vector<std::string> failures;  ///< the first few of Sightline's, in full

  void add(const BoxTally& other);
};

/// `count` pairs of the family, which the seed alone decides.
BoxTally judge_pairs(const RayBoxFamily& family, std::uint64_t seed, std::uint64_t count);
BoxTally judge_pairs(const TriangleBoxFamily& family, std::uint64_t seed, std::uint64_t count);

}  // namespace sightline::stress
