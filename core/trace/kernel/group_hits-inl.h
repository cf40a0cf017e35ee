// GroupHits: the best hits so far of the rays of a packet.

#if defined(SIGHTLINE_TRACE_GROUP_HITS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_GROUP_HITS_INL_H_
#undef SIGHTLINE_TRACE_GROUP_HITS_INL_H_
#else
#define SIGHTLINE_TRACE_GROUP_HITS_INL_H_
#endif

#include <bit>

#include "core/trace/counting_sides.h"
#include "core/trace/decision.h"
#include "core/trace/kernel/filter-inl.h"
#include "core/trace/kernel/kernel.h"
#include "core/trace/kernel/prepare-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// The ClosestHit of each of at most kRays rays, as columns. Call start() for a packet, enter() for
/// each placement, then the take functions for verdicts of the filter. Ray i is lane i of the
/// packet. The bound of a ray is the upper bound of its best tau so far.
template <std::size_t kRays>
class GroupHits {
 public:
  using D = GroupPreparation::D;

  /// `resolved`: which triangles count; null: all. All arguments must outlive this object.
  GroupHits(const SceneView& scene, const RayBatch& rays, const ResolvedFilter* resolved,
            TraceCounts& counts)
      : scene_(scene), tree_(scene.tree()), rays_(rays), resolved_(resolved), counts_(counts) {}

  /// Resets to no hits, for `count` rays, whole vectors, from `first` of the batch on; `tau_max`
  /// are the upper ends of their limits.
  void start(std::size_t first, const double* tau_max, std::size_t count) {
    first_ = first;
    const D dd;
    const hn::RebindToUnsigned<D> du;
    for (std::size_t i = 0; i < count; i += hn::Lanes(dd)) {
      hn::Store(hn::Set(dd, ClosestHit::kNever), dd, low_ + i);
      hn::Store(hn::Load(dd, tau_max + i), dd, bound_ + i);
      hn::Store(hn::Zero(du), du, candidate_ + i);
    }
  }
  /// Sets a bound for lane i, which has no ray; a bound below all tau excludes all triangles.
  void exclude(std::size_t i, double bound) { bound_[i] = bound; }

  /// Enters a placement, by its index in SceneTree::placements: the following blocks are in its
  /// tree.
  void enter(std::uint32_t placement) {
    number_ = placement;
    entered_ = &tree_.placements[placement];
    base_ = tree_.trees[entered_->tree]->arena.at(0);
  }
  /// The placement of a block of the entered tree.
  const Placement& placement(const LeafBlock& block) const { return entered_[block.placement()]; }

  /// The bound of ray i, all bounds, and the closest hit of ray i.
  double bound(std::size_t i) const { return bound_[i]; }
  const double* bounds() const { return bound_; }
  Candidate winner(std::size_t i) const { return decode(candidate_[i]); }

  /// Removes triangles that do not count for ray i from the verdict. Returns false if none is left.
  HWY_INLINE bool does_count(std::uint32_t i, const LeafBlock& block, LeafVerdict& verdict) const {
    if (HWY_LIKELY(resolved_ == nullptr)) return true;
    const RayQuestion question{scene_, rays_, first_ + i, counts_.decisions};
    const std::uint32_t lanes =
        counting_lanes(question, *resolved_, block, placement(block).instance,
                       verdict.accept | verdict.examine, verdict.accept, verdict.back);
    verdict.accept &= lanes;
    verdict.examine &= lanes;
    return lanes != 0;
  }
  /// The sides of the triangle in a lane of the block whose hits count, for rays that no mask
  /// excludes: a set of ResolvedFilter's bits.
  HWY_INLINE std::uint8_t counting_sides(const LeafBlock& block, std::uint32_t lane) const {
    return HWY_LIKELY(resolved_ == nullptr) ? ResolvedFilter::kAll : sides_of(block, lane);
  }
  /// Returns those rays of `some` for which hits of the triangle in a lane count; bit j is ray
  /// first + j, `found` are their verdicts. `sides` is the result of counting_sides.
  HWY_INLINE std::uint32_t counting_rays(std::uint8_t sides, const LeafBlock& block,
                                         std::uint32_t lane, std::size_t first,
                                         const LaneVerdicts<D>& found, std::uint32_t some) const {
    if (HWY_LIKELY(resolved_ == nullptr)) return some;
    const std::uint32_t certain = mask_bits(D(), found.certain), back = mask_bits(D(), found.back);
    if (!resolved_->masks.empty()) some = rays_with_mask(block, first, some);
    if (sides == ResolvedFilter::kAll) return some;
    const std::uint32_t counting = ((sides & ResolvedFilter::kFront) != 0 ? ~back : 0u) |
                                   ((sides & ResolvedFilter::kBack) != 0 ? back : 0u);
    const std::uint32_t open = some & ~certain;
    some &= certain & counting;
    if (HWY_UNLIKELY(open != 0)) some |= examine_sides(block, lane, first, open);
    return some;
  }

  /// Adds the verdict of the filter for ray i and the triangles of a block, without triangles that
  /// do not count.
  HWY_INLINE void take_closest(std::uint32_t i, const LeafBlock& block,
                               const LeafVerdict& verdict) {
    for (std::uint32_t rest = verdict.accept; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(rest));
      const Candidate candidate{&block, lane, placement(block).instance, 0};
      const Interval tau{verdict.low[lane], verdict.high[lane]};
      if (tau.high < low_[i]) {
        low_[i] = tau.low;
        bound_[i] = tau.high;
        candidate_[i] = encode(candidate);
      } else if (HWY_UNLIKELY(!(tau.low > bound_[i]))) {
        settle(i, candidate, tau);
      }
    }
    if (HWY_UNLIKELY(verdict.examine != 0)) examine_closest(i, block, verdict.examine);
  }
  /// Adds the verdicts of the triangle in a lane for the rays from `first` on. `certain`: rays that
  /// certainly meet it; `examine`: rays for which the exact predicate must decide. Bit j of both is
  /// ray first + j.
  HWY_INLINE void take_nearer(const LeafBlock& block, std::uint32_t lane, std::size_t first,
                              const LaneVerdicts<D>& found, std::uint32_t certain,
                              std::uint32_t examine) {
    const D dd;
    const hn::RebindToUnsigned<D> du;
    const auto best_low = hn::Load(dd, low_ + first);
    const auto best_high = hn::Load(dd, bound_ + first);
    const std::uint32_t nearer = mask_bits(dd, hn::Lt(found.high, best_low)) & certain;
    const std::uint32_t farther = mask_bits(dd, hn::Gt(found.low, best_high)) & certain;
    const auto bits = static_cast<std::uint8_t>(nearer);
    const auto take = hn::LoadMaskBits(dd, &bits);
    hn::Store(hn::IfThenElse(take, found.low, best_low), dd, low_ + first);
    hn::Store(hn::IfThenElse(take, found.high, best_high), dd, bound_ + first);
    hn::Store(hn::IfThenElse(hn::RebindMask(du, take), hn::Set(du, encode({&block, lane, 0, 0})),
                             hn::Load(du, candidate_ + first)),
              du, candidate_ + first);
    const std::uint32_t clash = certain & ~nearer & ~farther;
    if (HWY_UNLIKELY((clash | examine) != 0)) {
      HWY_ALIGN double low[kGroupRays], high[kGroupRays];
      hn::Store(found.low, dd, low);
      hn::Store(found.high, dd, high);
      for (std::uint32_t rest = clash; rest != 0; rest &= rest - 1) {
        const auto j = static_cast<std::uint32_t>(std::countr_zero(rest));
        settle(static_cast<std::uint32_t>(first) + j, {&block, lane, placement(block).instance, 0},
               {low[j], high[j]});
      }
      for (std::uint32_t rest = examine; rest != 0; rest &= rest - 1) {
        const auto j = static_cast<std::uint32_t>(std::countr_zero(rest));
        examine_closest(static_cast<std::uint32_t>(first) + j, block, 1u << lane);
      }
    }
  }

  /// True if the exact predicate finds that ray i meets one of the triangles `examine` of the
  /// block.
  HWY_NOINLINE bool examine_any_of(std::uint32_t i, const LeafBlock& block, std::uint32_t examine) {
    const RayQuestion question{scene_, rays_, first_ + i, counts_.decisions};
    for (; examine != 0; examine &= examine - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(examine));
      if (sightline::examine_any(question, {placement(block).instance, block.triangle(lane)}))
        return true;
    }
    return false;
  }

  /// Passes the closest hits of the first `count` rays to `finish`: all in one call of
  /// add_neighbours if it has kNeighbours, else one by one by add.
  template <class Finish>
  void hand_over(std::size_t count, Finish& finish) const {
    if constexpr (requires { Finish::kNeighbours; }) {
      finish.add_neighbours(first_, count, candidate_,
                            [this](std::uint64_t code) { return decode(code); });
    } else {
      for (std::size_t i = 0; i < count; ++i) {
        if (candidate_[i] != 0) finish.add(first_ + i, winner(i));
      }
    }
  }

 private:
  HWY_NOINLINE std::uint8_t sides_of(const LeafBlock& block, std::uint32_t lane) const {
    return sightline::counting_sides(scene_.scene(), *resolved_,
                                     {placement(block).instance, block.triangle(lane)});
  }
  /// Those rays of `some` whose mask shares a bit with that of the block's instance.
  HWY_NOINLINE std::uint32_t rays_with_mask(const LeafBlock& block, std::size_t first,
                                            std::uint32_t some) const {
    const std::uint32_t mask = resolved_->masks[placement(block).instance];
    for (std::uint32_t rest = some; rest != 0; rest &= rest - 1) {
      const auto j = static_cast<std::uint32_t>(std::countr_zero(rest));
      if ((mask & rays_.mask[first_ + first + j]) == 0) some &= ~(1u << j);
    }
    return some;
  }
  /// counting_rays by the exact sign of each ray's side.
  HWY_NOINLINE std::uint32_t examine_sides(const LeafBlock& block, std::uint32_t lane,
                                           std::size_t first, std::uint32_t some) const {
    for (std::uint32_t rest = some; rest != 0; rest &= rest - 1) {
      const auto j = static_cast<std::uint32_t>(std::countr_zero(rest));
      const RayQuestion question{scene_, rays_, first_ + first + j, counts_.decisions};
      if (counting_lanes(question, *resolved_, block, placement(block).instance, 1u << lane, 0,
                         0) == 0)
        some &= ~(1u << j);
    }
    return some;
  }
  HWY_NOINLINE void settle(std::uint32_t i, const Candidate& candidate, Interval tau) {
    const RayQuestion question{scene_, rays_, first_ + i, counts_.decisions};
    ClosestHit best = best_of(i);
    best.settle(question, candidate, tau);
    keep(i, best);
  }

  HWY_NOINLINE void examine_closest(std::uint32_t i, const LeafBlock& block,
                                    std::uint32_t examine) {
    const RayQuestion question{scene_, rays_, first_ + i, counts_.decisions};
    ClosestHit best = best_of(i);
    for (; examine != 0; examine &= examine - 1) {
      best.examine(question, {&block, static_cast<std::uint32_t>(std::countr_zero(examine)),
                              placement(block).instance});
    }
    keep(i, best);
  }

  /// Encodes a candidate in one number; 0 is none. It holds the entered placement, the block's
  /// granule plus 1, `edge` and `lane`.
  std::uint64_t encode(const Candidate& candidate) const {
    const auto* block = reinterpret_cast<const std::byte*>(candidate.block);
    const auto granule = static_cast<std::uint64_t>(block - base_) / Arena::kGranule;
    return std::uint64_t{number_} << 34 | (granule + 1) << 5 | candidate.edge << 2 | candidate.lane;
  }
  Candidate decode(std::uint64_t code) const {
    if (code == 0) return {};
    const Placement* entered = entered_;
    const std::byte* base = base_;
    if (HWY_UNLIKELY(code >> 34 != number_)) {
      entered = &tree_.placements[code >> 34];
      base = tree_.trees[entered->tree]->arena.at(0);
    }
    const std::uint64_t granule = (code >> 5 & 0x1fffffffu) - 1;
    const auto* block = reinterpret_cast<const LeafBlock*>(base + granule * Arena::kGranule);
    const auto low = static_cast<std::uint32_t>(code);
    return {block, low & 3u, entered[block->placement()].instance, low >> 2 & 7u};
  }
  ClosestHit best_of(std::uint32_t i) const {
    ClosestHit best;
    best.tau = {low_[i], bound_[i]};
    if (candidate_[i] != 0) best.candidate = decode(candidate_[i]);
    return best;
  }
  void keep(std::uint32_t i, const ClosestHit& best) {
    low_[i] = best.tau.low;
    bound_[i] = best.tau.high;
    // A candidate that remains may have been found in another tree.
    const Candidate old = decode(candidate_[i]);
    if (best.candidate.block == old.block && best.candidate.instance == old.instance &&
        best.candidate.lane == old.lane)
      return;
    candidate_[i] = encode(best.candidate);
  }

  const SceneView& scene_;
  const SceneTree& tree_;
  const RayBatch& rays_;
  const ResolvedFilter* resolved_;
  TraceCounts& counts_;
  std::size_t first_ = 0;
  // The entered placement: its number, itself, and the start of its tree.
  std::uint32_t number_ = 0;
  const Placement* entered_ = nullptr;
  const std::byte* base_ = nullptr;
  HWY_ALIGN double low_[kRays];
  HWY_ALIGN double bound_[kRays];
  HWY_ALIGN std::uint64_t candidate_[kRays];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
