// Shares the rays of a batch out to packets and the flight.

#if defined(SIGHTLINE_TRACE_TOGETHER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_TOGETHER_INL_H_
#undef SIGHTLINE_TRACE_TOGETHER_INL_H_
#else
#define SIGHTLINE_TRACE_TOGETHER_INL_H_
#endif

#include <algorithm>

#include "core/trace/flight-inl.h"
#include "core/trace/packet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Whether the rays of a batch of this size can go together.
inline bool can_go_together(const Scene& scene, std::size_t count) {
  const SceneTree& tree = scene.tree();
  return count > 1 && tree.placements.size() == 1 && tree.placements[0].world_boxes &&
         tree.trees[tree.placements[0].tree]->depth <= kMaxFlightDepth;
}

/// Takes sixteen rays at a time as a packet while that is the cheaper way, and the others, some
/// thousands at a time, as a flight.
template <bool kAny, bool kPlaced>
class Together {
 public:
  Together(const Scene& scene, const RayBatch& rays, std::uint8_t* occluded, TraceCounts& counts)
      : packet_(scene, rays, occluded, counts), flight_(scene, rays, occluded, counts) {}

  template <class Finish>
  void run(std::size_t begin, std::size_t end, Finish& finish) {
    while (begin < end) {
      const std::size_t stop = std::min(end, begin + kChunk);
      while (begin < stop) begin = take(begin, stop, finish);
      flight_.run({groups_, group_count_}, finish);
      group_count_ = 0;
    }
  }

 private:
  static constexpr std::size_t kChunk = 4096;
  /// Packets are tried again after a while, later every time they have not paid.
  static constexpr std::size_t kLongestPause = 64;

  /// Traces or puts off the next rays; returns the first that is left.
  template <class Finish>
  HWY_INLINE std::size_t take(std::size_t begin, std::size_t stop, Finish& finish) {
    if constexpr (kPacketsWork) {
      if (wait_ > 0) {
        --wait_;
      } else if (begin + kPacketRays <= stop) {
        if (packet_.prepare(begin)) {
          pause_ = packet_.trace(finish) ? 0 : std::min(2 * pause_ + 2, kLongestPause);
          wait_ = pause_;
          return begin + kPacketRays;
        }
      }
    }
    const std::size_t last = std::min(stop, begin + kPacketRays);
    for (; begin < last; begin += kGroupRays) {
      groups_[group_count_++] = {static_cast<std::uint32_t>(begin),
                                 static_cast<std::uint32_t>(std::min(kGroupRays, last - begin))};
    }
    return last;
  }

  Packet<kAny, kPlaced> packet_;
  Flight<kAny, kPlaced> flight_;
  std::size_t wait_ = 0, pause_ = 0;
  std::size_t group_count_ = 0;
  RayGroup groups_[kChunk / kGroupRays];
};

/// The finisher of "any", which has nothing to round.
struct NoFinisher {
  void add(std::size_t, const Candidate&) {}
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
