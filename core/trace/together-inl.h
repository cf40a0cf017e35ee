// The batch scheduler: distributes the rays of a batch to packets and interleaved traversal.

#if defined(SIGHTLINE_TRACE_TOGETHER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_TOGETHER_INL_H_
#undef SIGHTLINE_TRACE_TOGETHER_INL_H_
#else
#define SIGHTLINE_TRACE_TOGETHER_INL_H_
#endif

#include <algorithm>
#include <optional>
#include <type_traits>

#include "core/trace/crowd-inl.h"
#include "core/trace/flight-inl.h"
#include "core/trace/packet-inl.h"
#include "core/trace/window-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Whether a batch of this size may be traced in packets.
inline bool can_go_together(const SceneView& scene, std::size_t count) {
  const SceneTree& tree = scene.tree();
  return count > 1 && tree.depth <= kMaxFlightDepth &&
         (tree.entries > 1 || tree.placements[0].world_boxes);
}

/// Calls `call` for the layout of a scene that may be traced in packets.
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

/// How many rays from `first` on to trace interleaved before a packet is worth a try. Compares the
/// octants of the next few rays, of which there must be kNarrowRays.
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

/// Traces neighbouring rays as packets (masked packets over instances) while that is faster. Rays
/// that diverge are binned by octant and origin if that makes packets of them. All others are
/// traced interleaved, some thousands at a time.
template <bool kAny, Layout kLayout>
class Together {
 public:
  /// `kept`: which triangles count; null: all of them.
  Together(const SceneView& scene, const RayBatch& rays, std::uint8_t* occluded,
           const KeptSides* kept, TraceCounts& counts)
      : scene_(scene),
        rays_(rays),
        occluded_(occluded),
        kept_(kept),
        counts_(counts),
        group_(scene, rays, occluded, kept, counts),
        flight_(scene, rays, occluded, kept, counts) {}

  template <class Finish>
  void run(std::size_t begin, std::size_t end, Finish& finish) {
    while (begin < end) {
      const std::size_t in_order = step_in_order(begin, end - begin, finish);
      begin += in_order > 0 ? in_order : step(begin, end - begin, finish);
      if (group_count_ + kNarrowRays / kGroupRays > kGroups || begin == end) fly(finish);
    }
  }

 private:
  using Group = std::conditional_t<kLayout == Layout::kMany, Crowd<kAny>, Packet<kAny, kLayout>>;
  using Rays = Window<kAny, kLayout>;
  static constexpr std::size_t kGroups = 512;
  static constexpr std::size_t kFirstWindowPause = 512, kLongestWindowPause = 8192;  ///< in rays
  /// Both are tried again after a while, later every time they have not paid.
  static constexpr std::size_t kLongestPause = 64;

  /// Traces some rays from `begin` on as packets whatever their directions, where that pays.
  /// Returns how many.
  template <class Finish>
  HWY_INLINE std::size_t step_in_order(std::size_t begin, std::size_t left, Finish& finish) {
    if constexpr (kLayout != Layout::kMany && kPacketsWork) {
      if (begin < window_from_ || left < Rays::kFewest) return 0;
      if (rays_before(rays_, begin) > 0) return trace_window(begin, left, finish);
      window_from_ = begin + Rays::kFewest / 2;  // alike as they are
    }
    return 0;
  }
  template <class Finish>
  HWY_NOINLINE std::size_t trace_window(std::size_t begin, std::size_t left, Finish& finish) {
    if (!window_) window_.emplace(scene_, rays_, occluded_, kept_, counts_);
    const auto pause_from = [&](std::size_t end) {
      window_pause_ = std::min(2 * window_pause_, kLongestWindowPause);
      window_from_ = end + window_pause_;
    };
    if (!window_pays_ && !window_->is_promising(begin)) {
      pause_from(begin);
      return 0;
    }
    const std::size_t count = std::min(left, window_pays_ ? Rays::kMost : 2 * Rays::kFewest);
    window_pays_ = window_->trace(begin, count, finish, [&](std::size_t ray) {
      if (group_count_ == kGroups) fly(finish);
      groups_[group_count_++] = {static_cast<std::uint32_t>(ray), 1};
    });
    if (window_pays_) {
      window_pause_ = kFirstWindowPause;
    } else {
      pause_from(begin + count);
    }
    return count;
  }

  template <class Finish>
  void fly(Finish& finish) {
    flight_.run({groups_, group_count_}, finish);
    group_count_ = 0;
  }

  /// Traces some rays from `begin` on as a packet, or leaves them to interleaved traversal. Returns
  /// how many.
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
  const KeptSides* kept_;
  TraceCounts& counts_;
  Group group_;
  Flight<kAny, kLayout> flight_;
  std::size_t wait_ = 0, pause_ = 0;
  std::optional<Rays> window_;
  bool window_pays_ = false;  ///< the last one did
  std::size_t window_from_ = 0, window_pause_ = kFirstWindowPause;
  std::size_t group_count_ = 0;
  RayGroup groups_[kGroups];
};

/// Finishes a hit of "any", which has no t to round.
struct NoFinisher {
  void add(std::size_t, const Candidate&) {}
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
