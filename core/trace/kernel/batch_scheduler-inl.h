// The batch scheduler: distributes the rays of a batch to packets and interleaved traversal.

#if defined(SIGHTLINE_TRACE_BATCH_SCHEDULER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_BATCH_SCHEDULER_INL_H_
#undef SIGHTLINE_TRACE_BATCH_SCHEDULER_INL_H_
#else
#define SIGHTLINE_TRACE_BATCH_SCHEDULER_INL_H_
#endif

#include <algorithm>
#include <optional>
#include <type_traits>

#include "core/trace/kernel/interleaved-inl.h"
#include "core/trace/kernel/masked_packet-inl.h"
#include "core/trace/kernel/packet-inl.h"
#include "core/trace/kernel/ray_binning-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// True if a batch of this size may be given to BatchScheduler: the scene's trees are not too deep,
/// and a single entry has world boxes. Precondition: the scene has entries.
inline bool can_use_packets(const SceneView& scene, std::size_t count) {
  const SceneTree& tree = scene.tree();
  return count > 1 && tree.depth <= kMaxInterleavedDepth &&
         (tree.entries > 1 || tree.placements[0].world_boxes);
}

/// Calls call.operator()<Layout>() for the layout of a scene. Precondition: can_use_packets.
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

/// Returns how many rays from `first` on to trace interleaved before it is worth trying a packet: 0
/// if a packet may begin at `first`. It compares the octants of the next rays. Precondition:
/// kNarrowRays rays exist from `first` on.
inline std::size_t rays_before(const RayBatch& rays, std::size_t first) {
  const auto octant = [&](std::size_t i) {
    return (std::signbit(rays.dx[i]) ? 1 : 0) | (std::signbit(rays.dy[i]) ? 2 : 0) |
           (std::signbit(rays.dz[i]) ? 4 : 0);
  };
  int last = octant(first);
  std::size_t alike = 1;
  for (std::size_t i = 1; i < 2 * kFewestRays - 1; ++i) {
    const int next = octant(first + i);
    alike = next == last ? alike + 1 : 1;
    last = next;
    if (alike == kFewestRays) return i + 1 - kFewestRays;
  }
  return kNarrowRays;
}

/// Distributes the rays of a batch to the traversal methods. Neighbouring rays go as packets
/// (masked packets if there are several entries) while that is faster. Rays that diverge are binned
/// by octant and origin, if that makes packets of them. All others are traced interleaved, some
/// thousands at a time.
template <bool kAny, Layout kLayout>
class BatchScheduler {
 public:
  /// `resolved`: which triangles count; null: all. `occluded` is written for "any", else null. All
  /// arguments must outlive this object. Precondition: can_use_packets.
  BatchScheduler(const SceneView& scene, const RayBatch& rays, std::uint8_t* occluded,
                 const ResolvedFilter* resolved, TraceCounts& counts)
      : scene_(scene),
        rays_(rays),
        occluded_(occluded),
        resolved_(resolved),
        counts_(counts),
        group_(scene, rays, occluded, resolved, counts),
        interleaved_(scene, rays, occluded, resolved, counts) {}

  /// Traces rays [begin, end). finish.add(ray, candidate) is called for each closest hit, in no
  /// fixed order. Results are unusable if the deadline passes (TraceCounts::stopped).
  template <class Finish>
  void run(std::size_t begin, std::size_t end, Finish& finish) {
    while (begin < end) {
      const std::size_t in_order = step_in_order(begin, end - begin, finish);
      begin += in_order > 0 ? in_order : step(begin, end - begin, finish);
      if (group_count_ + kNarrowRays / kGroupRays > kGroups || begin == end) fly(finish);
    }
  }

 private:
  using Group =
      std::conditional_t<kLayout == Layout::kMany, MaskedPacket<kAny>, Packet<kAny, kLayout>>;
  using Rays = RayBins<kAny, kLayout>;
  static constexpr std::size_t kGroups = 512;
  static constexpr std::size_t kFirstBinningPause = 512, kLongestBinningPause = 8192;  ///< in rays
  /// Packets and bins are tried again after a pause, which grows each time that they were slower.
  static constexpr std::size_t kLongestPause = 64;

  /// Traces some rays from `begin` on as binned packets, if that pays. Returns how many; 0 if none.
  template <class Finish>
  HWY_INLINE std::size_t step_in_order(std::size_t begin, std::size_t left, Finish& finish) {
    if constexpr (kLayout != Layout::kMany && kPacketsWork) {
      if (begin < binning_from_ || left < Rays::kFewest) return 0;
      if (rays_before(rays_, begin) > 0) return trace_binned(begin, left, finish);
      binning_from_ = begin + Rays::kFewest / 2;  // the rays are similar already
    }
    return 0;
  }
  template <class Finish>
  HWY_NOINLINE std::size_t trace_binned(std::size_t begin, std::size_t left, Finish& finish) {
    if (!bins_) bins_.emplace(scene_, rays_, occluded_, resolved_, counts_);
    const auto pause_from = [&](std::size_t end) {
      binning_pause_ = std::min(2 * binning_pause_, kLongestBinningPause);
      binning_from_ = end + binning_pause_;
    };
    if (!binning_pays_ && !bins_->is_promising(begin)) {
      pause_from(begin);
      return 0;
    }
    const std::size_t count = std::min(left, binning_pays_ ? Rays::kMost : 2 * Rays::kFewest);
    binning_pays_ = bins_->trace(begin, count, finish, [&](std::size_t ray) {
      if (group_count_ == kGroups) fly(finish);
      groups_[group_count_++] = {static_cast<std::uint32_t>(ray), 1};
    });
    if (binning_pays_) {
      binning_pause_ = kFirstBinningPause;
    } else {
      pause_from(begin + count);
    }
    return count;
  }

  /// Traces the queued groups interleaved.
  template <class Finish>
  void fly(Finish& finish) {
    interleaved_.run({groups_, group_count_}, finish);
    group_count_ = 0;
  }

  /// Traces some rays from `begin` on as a packet, or queues them for interleaved traversal.
  /// Returns how many.
  template <class Finish>
  HWY_INLINE std::size_t step(std::size_t begin, std::size_t left, Finish& finish) {
    std::size_t alone = std::min(left, kNarrowRays);
    if constexpr (kPacketsWork) {
      if (wait_ > 0) {
        --wait_;
      } else if (left >= kNarrowRays) {
        alone = rays_before(rays_, begin);
        if (alone == 0) {
          const std::size_t count =
              group_.prepare(begin, left < kPacketRays ? kNarrowRays : kPacketRays);
          if (count >= kFewestRays) {
            pause_ = group_.trace(finish) ? 0 : std::min(2 * pause_ + 2, kLongestPause);
            wait_ = pause_;
            return count;
          }
          alone = count > 0 ? count : kNarrowRays;
        }
      }
    }
    for (std::size_t i = 0; i < alone; i += kGroupRays) {
      groups_[group_count_++] = {static_cast<std::uint32_t>(begin + i),
                                 static_cast<std::uint32_t>(std::min(kGroupRays, alone - i))};
    }
    return alone;
  }

  const SceneView& scene_;
  const RayBatch& rays_;
  std::uint8_t* occluded_;
  const ResolvedFilter* resolved_;
  TraceCounts& counts_;
  Group group_;
  Interleaved<kAny, kLayout> interleaved_;
  std::size_t wait_ = 0, pause_ = 0;
  std::optional<Rays> bins_;
  bool binning_pays_ = false;  ///< the last binning was faster
  std::size_t binning_from_ = 0, binning_pause_ = kFirstBinningPause;
  std::size_t group_count_ = 0;
  RayGroup groups_[kGroups];
};

/// Takes the hits of "any", which have no t to round.
struct NoRounding {
  void add(std::size_t, const Candidate&) {}
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
