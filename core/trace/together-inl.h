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
inline bool can_go_together(const SceneView& scene, std::size_t count) {
  const SceneTree& tree = scene.tree();
  return count > 1 && tree.depth <= kMaxFlightDepth &&
         (tree.entries > 1 || tree.placements[0].world_boxes);
}

/// Calls `call` for the layout of a scene that can go together.
template <class Call>
void with_layout(const SceneView& scene, Call&& call) {
  const SceneTree& tree = scene.tree();
  if (tree.entries > 1) {
    call.template operator()<Layout::kMany>();
  } else if (tree.placements[0].identity) {
    call.template operator()<Layout::kAsItIs>();
  } else {
    call.template operator()<Layout::kPlaced>();
  }
}

/// Takes neighbouring rays as packets while that is the cheaper way, and the others, some thousands
/// at a time, as a flight.
template <bool kAny, Layout kLayout>
class Together {
 public:
  Together(const SceneView& scene, const RayBatch& rays, std::uint8_t* occluded,
           TraceCounts& counts)
      : packet_(scene, rays, occluded, counts), flight_(scene, rays, occluded, counts) {}

  template <class Finish>
  void run(std::size_t begin, std::size_t end, Finish& finish) {
    while (begin < end) {
      begin += step(begin, end - begin, finish);
      if (group_count_ + kPacketRays / kGroupRays > kGroups || begin == end) {
        flight_.run({groups_, group_count_}, finish);
        group_count_ = 0;
      }
    }
  }

 private:
  static constexpr std::size_t kGroups = 512;
  /// Packets are tried again after a while, later every time they have not paid.
  static constexpr std::size_t kLongestPause = 64;

  /// Traces some rays from `begin` on as a packet, or puts them off until the next flight. Returns
  /// how many.
  template <class Finish>
  HWY_INLINE std::size_t step(std::size_t begin, std::size_t left, Finish& finish) {
    std::size_t alone = std::min(left, kPacketRays);
    if constexpr (kPacketsWork && kLayout != Layout::kMany) {
      if (wait_ > 0) {
        --wait_;
      } else if (left >= kPacketRays) {
        alone = packet_.rays_before(begin);
        if (alone == 0) {
          const std::size_t count = packet_.prepare(begin);
          if (count >= kFewestRays) {
            pause_ = packet_.trace(finish) ? 0 : std::min(2 * pause_ + 2, kLongestPause);
            wait_ = pause_;
            return count;
          }
          alone = count > 0 ? count : kPacketRays;
        }
      }
    }
    for (std::size_t i = 0; i < alone; i += kGroupRays) {
      groups_[group_count_++] = {static_cast<std::uint32_t>(begin + i),
                                 static_cast<std::uint32_t>(std::min(kGroupRays, alone - i))};
    }
    return alone;
  }

  Packet<kAny, kLayout> packet_;
  Flight<kAny, kLayout> flight_;
  std::size_t wait_ = 0, pause_ = 0;
  std::size_t group_count_ = 0;
  RayGroup groups_[kGroups];
};

/// The finisher of "any", which has nothing to round.
struct NoFinisher {
  void add(std::size_t, const Candidate&) {}
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
