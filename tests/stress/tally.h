#pragma once
/// What is counted of a family: for the peers how often and how far they are off, for Sightline
/// every promise.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/stress/contestant.h"

namespace sightline::stress {

/// Errors of t in ulp of the correctly rounded t; the median to within 10%.
class ErrorHistogram {
 public:
  void add(double ulp);
  void add(const ErrorHistogram& other);
  double worst() const { return worst_; }
  double median() const;
  std::uint64_t count() const { return count_; }

 private:
  /// Bin 0: no error. Then eight bins per power of two from 2^-16 on.
  static constexpr int kPerOctave = 8, kLeast = -16, kOctaves = 1100;
  std::vector<std::uint64_t> bins_;
  std::uint64_t count_ = 0;
  double worst_ = 0;
};

struct PeerTally {
  std::uint64_t asked = 0;
  std::uint64_t false_hits = 0;
  std::uint64_t false_misses = 0;
  std::uint64_t wrong_primitive = 0;  ///< another triangle, and not at the same exact t
  std::uint64_t other_of_tie = 0;     ///< another triangle at exactly the same t
  ErrorHistogram t_error;             ///< where it names a triangle at the exact closest t

  std::uint64_t wrong() const { return false_hits + false_misses + wrong_primitive; }
  void add(const PeerTally& other);
};

/// Every count but the first four must be zero.
struct SightlineTally {
  std::uint64_t rays = 0, hits = 0;
  std::uint64_t lists = 0;     ///< rays whose all and count were judged
  std::uint64_t parities = 0;  ///< whole lines through closed meshes that were counted once

  std::uint64_t false_hits = 0, false_misses = 0, wrong_primitive = 0;
  std::uint64_t t_bits = 0;  ///< right triangle, t not the correctly rounded one
  std::uint64_t any = 0, all = 0, count = 0, once = 0, parity = 0;
  std::uint64_t position = 0, barycentric = 0, normal = 0, front = 0;
  double worst_position_ulp = 0, worst_barycentric = 0, worst_normal = 0;

  std::uint64_t wrong() const;
  void add(const SightlineTally& other);
};

struct FamilyTally {
  SightlineTally sightline;
  std::array<PeerTally, kPeerNames.size()> peers;
  double seconds = 0;
  std::vector<std::string> failures;  ///< the first few wrong answers of Sightline, in full

  void add(const FamilyTally& other);
};

}  // namespace sightline::stress
