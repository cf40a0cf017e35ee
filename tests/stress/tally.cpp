#include "tests/stress/tally.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::stress {

void ErrorHistogram::add(double ulp) {
  if (bins_.empty()) bins_.resize(kPerOctave * kOctaves + 2);
  if (std::isnan(ulp)) ulp = std::numeric_limits<double>::infinity();
  int bin = 0;
  if (ulp > 0) {
    const double place = kPerOctave * (std::log2(ulp) - kLeast);
    bin = 1 + static_cast<int>(std::clamp(place, 0.0, 1.0 * kPerOctave * kOctaves));
  }
  ++bins_[static_cast<std::size_t>(bin)];
  ++count_;
  worst_ = std::max(worst_, ulp);
}

void ErrorHistogram::add(const ErrorHistogram& other) {
  if (other.count_ == 0) return;
  if (bins_.empty()) bins_.resize(other.bins_.size());
  for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += other.bins_[i];
  count_ += other.count_;
  worst_ = std::max(worst_, other.worst_);
}

double ErrorHistogram::median() const {
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    below += bins_[i];
    if (2 * below >= count_) {
      if (i == 0) return 0;
      const double middle = std::exp2((static_cast<double>(i) - 0.5) / kPerOctave + kLeast);
      return std::min(middle, worst_);
    }
  }
  return 0;
}

void PeerTally::add(const PeerTally& other) {
  asked += other.asked;
  false_hits += other.false_hits;
  false_misses += other.false_misses;
  wrong_primitive += other.wrong_primitive;
  other_of_tie += other.other_of_tie;
  t_error.add(other.t_error);
}

std::uint64_t SightlineTally::wrong() const {
  return false_hits + false_misses + wrong_primitive + t_bits + any + all + count + once + parity +
         position + barycentric + normal + front;
}

void SightlineTally::add(const SightlineTally& other) {
  for (const auto member :
       {&SightlineTally::rays, &SightlineTally::hits, &SightlineTally::lists,
        &SightlineTally::parities, &SightlineTally::false_hits, &SightlineTally::false_misses,
        &SightlineTally::wrong_primitive, &SightlineTally::t_bits, &SightlineTally::any,
        &SightlineTally::all, &SightlineTally::count, &SightlineTally::once,
        &SightlineTally::parity, &SightlineTally::position, &SightlineTally::barycentric,
        &SightlineTally::normal, &SightlineTally::front})
    this->*member += other.*member;
  for (const auto member : {&SightlineTally::worst_position_ulp, &SightlineTally::worst_barycentric,
                            &SightlineTally::worst_normal})
    this->*member = std::max(this->*member, other.*member);
}

void FamilyTally::add(const FamilyTally& other) {
  sightline.add(other.sightline);
  for (std::size_t i = 0; i < peers.size(); ++i) peers[i].add(other.peers[i]);
  seconds += other.seconds;
  constexpr std::size_t kShown = 20;
  for (const std::string& text : other.failures) {
    if (failures.size() < kShown) failures.push_back(text);
  }
}

}  // namespace sightline::stress
