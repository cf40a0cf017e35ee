// Sixteen neighbouring rays through one tree together: rays of a camera or a scanner that run side
// by side meet the same nodes.
//
//   beam    the box of all sixteen rays' slabs: culls the eight children of a node at once
//   rays    a child that the beam meets is asked for by each ray when its turn comes, by then with
//           the limits that earlier leaves have left
//   leaf    the corners of a block are loaded once and filtered for each ray that meets its box
//
// Where rays do not stay together this is slower than the flight; the packet counts what both would
// have cost.

#if defined(SIGHTLINE_TRACE_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_PACKET_INL_H_
#undef SIGHTLINE_TRACE_PACKET_INL_H_
#else
#define SIGHTLINE_TRACE_PACKET_INL_H_
#endif

#include <bit>

#include "core/trace/decision.h"
#include "core/trace/filter-inl.h"
#include "core/trace/kernel.h"
#include "core/trace/prepare-inl.h"
#include "core/trace/slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

constexpr std::size_t kPacketRays = 16;
/// Below eight lanes there is nothing to win.
constexpr bool kPacketsWork = HWY_MAX_BYTES >= 32;

template <bool kAny, bool kPlaced>
class Packet {
 public:
  Packet(const Scene& scene, const RayBatch& rays, std::uint8_t* occluded, TraceCounts& counts)
      : scene_(scene),
        placement_(scene.tree().placements[0]),
        tree_(*scene.tree().trees[placement_.tree]),
        rays_(rays),
        occluded_(occluded),
        counts_(counts),
        preparation_(scene.tree().bounds, tree_.scale_exponent),
        scale_(std::ldexp(1.0, tree_.scale_exponent)) {}

  /// Sets up the rays from `first` on; false if they cannot go together.
  bool prepare(std::size_t first) {
    first_ = first;
    if (!look_alike()) return false;
    for (std::uint32_t& bits : columns_.negative) bits = 0;
    columns_.largest_x = columns_.largest_y = 0;
    constexpr std::size_t kStep = hn::MaxLanes(GroupPreparation::D());
    std::uint32_t simple = 0;
    for (std::size_t i = 0; i < kPacketRays; i += kStep) {
      simple |= preparation_.prepare_columns(rays_, first + i, i, columns_) << i;
    }
    const auto agree = [](std::uint32_t bits) { return bits == 0 || bits == kAllRays; };
    if (simple != kAllRays || !agree(columns_.negative[0]) || !agree(columns_.negative[1]) ||
        !agree(columns_.negative[2]) || !agree(columns_.largest_x) || !agree(columns_.largest_y)) {
      return false;
    }
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      best_[i] = ClosestHit(columns_.tau_max[i]);
      limit_[i] = BoxRay::limit(columns_.tau_max[i], scale_);
    }
    set_beam();
    return true;
  }

  /// Traces what `prepare` has set up. True if the flight would have cost more.
  template <class Finish>
  bool trace(Finish& finish) {
    steps_ = ray_steps_ = 0;
    walk();
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      if constexpr (kAny) {
        occluded_[first_ + i] = limit_[i] == -kInfF ? 1 : 0;
      } else {
        if (best_[i].found()) finish.add(first_ + i, best_[i].candidate);
      }
    }
    counts_.nodes += ray_steps_;
    return steps_ < ray_steps_;
  }

 private:
  using D = hn::CappedTag<float, kPacketRays>;
  static constexpr std::uint32_t kAllRays = (1u << kPacketRays) - 1u;

  /// A child that waits for its turn.
  struct Waiting {
    HWY_ALIGN std::uint32_t parent[kWaiting];
    HWY_ALIGN std::uint32_t slot[kWaiting];
    HWY_ALIGN float near[kWaiting];  ///< of the beam
  };

  /// A quick look at three of the rays, before anything is computed.
  bool look_alike() const {
    const auto octant = [&](std::size_t i) {
      return (std::signbit(rays_.dx[i]) ? 1 : 0) | (std::signbit(rays_.dy[i]) ? 2 : 0) |
             (std::signbit(rays_.dz[i]) ? 4 : 0);
    };
    const int one = octant(first_);
    return one == octant(first_ + kPacketRays / 2) && one == octant(first_ + kPacketRays - 1);
  }

  static float least(const float* values) {
    const D d;
    auto low = hn::Load(d, values);
    for (std::size_t i = hn::Lanes(d); i < kPacketRays; i += hn::Lanes(d))
      low = hn::Min(low, hn::Load(d, values + i));
    return hn::GetLane(hn::MinOfLanes(d, low));
  }
  static float most(const float* values) {
    const D d;
    auto high = hn::Load(d, values);
    for (std::size_t i = hn::Lanes(d); i < kPacketRays; i += hn::Lanes(d))
      high = hn::Max(high, hn::Load(d, values + i));
    return hn::GetLane(hn::MaxOfLanes(d, high));
  }

  /// The beam enters a slab no later, and leaves it no earlier, than any of its rays: rounded
  /// differences and products are monotone, so the extremes of origins and inverses say so.
  void set_beam() {
    const bool negative[3] = {columns_.negative[0] != 0, columns_.negative[1] != 0,
                              columns_.negative[2] != 0};
    axes_ = columns_.filter(0);
    BoxRay rows;
    rows.set_octant(negative[0], negative[1], negative[2]);
    octant_ = rows.octant;
    for (std::size_t k = 0; k < 3; ++k) {
      near_row_[k] = rows.near_row[k];
      far_row_[k] = BoxRay::kBothRows[k] - rows.near_row[k];
      beam_.near_origin[k] =
          negative[k] ? least(columns_.near_origin[k]) : most(columns_.near_origin[k]);
      beam_.far_origin[k] =
          negative[k] ? most(columns_.far_origin[k]) : least(columns_.far_origin[k]);
      beam_.near_inverse[k][0] = least(columns_.near_inverse[k]);
      beam_.near_inverse[k][1] = most(columns_.near_inverse[k]);
      // The larger |inverse| last: it may be infinite.
      beam_.far_inverse[k][negative[k] ? 1 : 0] = least(columns_.far_inverse[k]);
      beam_.far_inverse[k][negative[k] ? 0 : 1] = most(columns_.far_inverse[k]);
    }
    beam_.tau_min = least(columns_.box_min);
    beam_.limit = most(limit_);
    reach_ = 0;
    for (const double reach : columns_.reach) reach_ = std::max(reach_, reach);
  }

  void walk() {
    std::size_t size = 0;
    if (ChildRef::is_leaf(tree_.root)) {
      visit_leaf(tree_.root, kAllRays);
      return;
    }
    size = expand(tree_.root, size);
    ray_steps_ += kPacketRays;
    while (size > 0) {
      --size;
      if (!(waiting_.near[size] <= beam_.limit)) continue;
      const WideNode& parent = tree_.node(waiting_.parent[size]);
      const std::uint32_t slot = waiting_.slot[size];
      const std::uint32_t ref = parent.child[slot];
      const std::uint32_t met = rays_that_meet(parent, slot);
      ++steps_;
      if (met == 0) continue;
      if (ChildRef::is_leaf(ref)) {
        visit_leaf(ref, met);
      } else {
        size = expand(ref, size);
        ray_steps_ += static_cast<std::uint32_t>(std::popcount(met));
      }
    }
  }

  /// Puts the children of a node that the beam meets on the stack, the nearest last.
  HWY_INLINE std::size_t expand(std::uint32_t ref, std::size_t size) {
    const WideNode& node = tree_.node(ref);
    const hn::CappedTag<float, kArity> df;
    const hn::RebindToUnsigned<decltype(df)> du;
    const float* planes = &node.lower[0][0];
    ++steps_;
    auto near = hn::Set(df, beam_.tau_min);
    auto far = hn::Set(df, beam_.limit);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const auto before =
          hn::Sub(hn::Load(df, planes + near_row_[k]), hn::Set(df, beam_.near_origin[k]));
      const auto behind =
          hn::Sub(hn::Load(df, planes + far_row_[k]), hn::Set(df, beam_.far_origin[k]));
      near = max_unless_nan(df,
                            hn::Min(hn::Mul(before, hn::Set(df, beam_.near_inverse[k][0])),
                                    hn::Mul(before, hn::Set(df, beam_.near_inverse[k][1]))),
                            near);
      // 0 * inf is NaN and says nothing.
      far = min_unless_nan(df,
                           nan_or_max(df, hn::Mul(behind, hn::Set(df, beam_.far_inverse[k][0])),
                                      hn::Mul(behind, hn::Set(df, beam_.far_inverse[k][1]))),
                           far);
    }
    const auto rank = child_order(node, octant_);
    const auto index = hn::IndicesFromVec(df, rank);
    const auto near_sorted = hn::TableLookupLanes(near, index);
    const auto hit = hn::Le(near_sorted, hn::TableLookupLanes(far, index));
    hn::StoreU(hn::Compress(near_sorted, hit), df, waiting_.near + size);
    hn::StoreU(hn::Compress(rank, hn::RebindMask(du, hit)), du, waiting_.slot + size);
    hn::StoreU(hn::Set(du, ref), du, waiting_.parent + size);
    return size + hn::CountTrue(df, hit);
  }

  /// Bit i: ray i meets the box of that child before its limit.
  HWY_INLINE std::uint32_t rays_that_meet(const WideNode& node, std::uint32_t slot) const {
    const D d;
    const float* planes = &node.lower[0][slot];
    std::uint32_t met = 0;
    for (std::size_t i = 0; i < kPacketRays; i += hn::Lanes(d)) {
      auto near = hn::Load(d, columns_.box_min + i);
      auto far = hn::Load(d, limit_ + i);
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        const auto before =
            hn::Sub(hn::Set(d, planes[near_row_[k]]), hn::Load(d, columns_.near_origin[k] + i));
        const auto behind =
            hn::Sub(hn::Set(d, planes[far_row_[k]]), hn::Load(d, columns_.far_origin[k] + i));
        near = max_unless_nan(d, hn::Mul(before, hn::Load(d, columns_.near_inverse[k] + i)), near);
        far = min_unless_nan(d, hn::Mul(behind, hn::Load(d, columns_.far_inverse[k] + i)), far);
      }
      met |= mask_bits(d, hn::Le(near, far)) << i;
    }
    return met;
  }

  HWY_INLINE void visit_leaf(std::uint32_t ref, std::uint32_t met) {
    const LeafBlock* block = tree_.blocks(ref);
    bool nearer = false;
    for (const LeafBlock* end = block + ChildRef::blocks(ref); block != end; ++block) {
      counts_.blocks += static_cast<std::uint32_t>(std::popcount(met));
      const BlockCorners corners = load_corners<kPlaced>(*block, 0, axes_, placement_);
      const double edge = largest_edge<kPlaced>(*block, placement_);
      const std::uint32_t lanes = (1u << block->lane_count) - 1u;
      for (std::uint32_t rest = met; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<std::uint32_t>(std::countr_zero(rest));
        LeafVerdict verdict;
        filter_corners(corners, edge, columns_.filter(i), reach_, best_[i].bound(), 0, verdict);
        verdict.accept &= lanes;
        verdict.examine &= lanes;
        if ((verdict.accept | verdict.examine) == 0) continue;
        if constexpr (kAny) {
          if (verdict.accept == 0 && !examine_any_of(i, *block, verdict.examine)) continue;
          limit_[i] = -kInfF;  // meets no box any more
          met &= ~(1u << i);
          nearer = true;
        } else {
          take_closest(i, *block, verdict);
          const float limit = BoxRay::limit(best_[i].bound(), scale_);
          nearer = nearer || limit < limit_[i];
          limit_[i] = limit;
        }
      }
    }
    if (nearer) beam_.limit = most(limit_);
  }

  HWY_INLINE void take_closest(std::uint32_t i, const LeafBlock& block,
                               const LeafVerdict& verdict) {
    for (std::uint32_t rest = verdict.accept; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(rest));
      const Candidate candidate{&block, lane, placement_.instance};
      const Interval tau{verdict.low[lane], verdict.high[lane]};
      if (HWY_UNLIKELY(!best_[i].accept(candidate, tau))) settle(i, candidate, tau);
    }
    if (HWY_UNLIKELY(verdict.examine != 0)) examine_closest(i, block, verdict.examine);
  }

  HWY_NOINLINE void settle(std::uint32_t i, const Candidate& candidate, Interval tau) {
    const RayQuestion question{scene_, rays_, first_ + i, counts_.decisions};
    best_[i].settle(question, candidate, tau);
  }

  HWY_NOINLINE void examine_closest(std::uint32_t i, const LeafBlock& block,
                                    std::uint32_t examine) {
    const RayQuestion question{scene_, rays_, first_ + i, counts_.decisions};
    for (; examine != 0; examine &= examine - 1) {
      best_[i].examine(question, {&block, static_cast<std::uint32_t>(std::countr_zero(examine)),
                                  placement_.instance});
    }
  }

  HWY_NOINLINE bool examine_any_of(std::uint32_t i, const LeafBlock& block, std::uint32_t examine) {
    const RayQuestion question{scene_, rays_, first_ + i, counts_.decisions};
    for (; examine != 0; examine &= examine - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(examine));
      if (sightline::examine_any(question, {placement_.instance, block.triangle[lane]}))
        return true;
    }
    return false;
  }

  const Scene& scene_;
  const Placement& placement_;
  const WideTree& tree_;
  const RayBatch& rays_;
  std::uint8_t* occluded_;
  TraceCounts& counts_;
  GroupPreparation preparation_;
  double scale_;
  std::size_t first_ = 0;
  PreparedColumns<kPacketRays> columns_;
  HWY_ALIGN float limit_[kPacketRays];  ///< minus infinity: this ray needs no more
  ClosestHit best_[kPacketRays];
  FilterRay axes_;    ///< kx, ky, kz of all rays
  double reach_ = 0;  ///< at least that of every ray
  std::uint32_t octant_ = 0;
  std::array<std::uint32_t, 3> near_row_{}, far_row_{};
  struct {
    float near_origin[3], far_origin[3], near_inverse[3][2], far_inverse[3][2];
    float tau_min, limit;
  } beam_;
  Waiting waiting_;
  std::uint64_t steps_ = 0;      ///< of the packet: nodes opened and boxes asked for by rays
  std::uint64_t ray_steps_ = 0;  ///< nodes that the rays would have visited one by one
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
