// Packet: up to 64 neighbouring rays traverse one tree as a group. Neighbouring rays of a camera
// or a scanner mostly visit the same nodes [Wald2001].
//
//   cull    the interval of the packet culls the eight children of a node at once [Boulos2006]
//   rays    when a child is popped, each ray tests its box, with the limits that earlier leaves
//           have set
//   leaf    the corners of a block are loaded once and filtered for all rays that meet its box
//
// If rays diverge, this is slower than interleaved traversal; the packet counts the steps of both.

#if defined(SIGHTLINE_TRACE_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_PACKET_INL_H_
#undef SIGHTLINE_TRACE_PACKET_INL_H_
#else
#define SIGHTLINE_TRACE_PACKET_INL_H_
#endif

#include <algorithm>
#include <bit>

#include "core/trace/kernel/filter-inl.h"
#include "core/trace/kernel/group_hits-inl.h"
#include "core/trace/kernel/interval_culling-inl.h"
#include "core/trace/kernel/kernel.h"
#include "core/trace/kernel/one_by_one-inl.h"
#include "core/trace/kernel/prepare-inl.h"
#include "core/trace/kernel/thresholds.h"
#include "core/trace/kernel/vertex_culling-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Whether packets are used: not with emulated vectors, which gain nothing.
constexpr bool kPacketsWork = SIGHTLINE_NATIVE_COMPRESS || SIGHTLINE_TABLE_COMPRESS;
using thresholds::kFewestRays;
using thresholds::kNarrowRays;
using thresholds::kPacketRays;

/// A packet, for scenes of one entry with world boxes. Call prepare(), then trace() if it returned
/// enough rays. One object serves the packets of a batch one after the other.
template <bool kAny, Layout kLayout>
class Packet {
  static constexpr bool kPlaced = kLayout != Layout::kAsItIs;

 public:
  /// `resolved`: which triangles count; null: all. `occluded` is written if kAny, else null. All
  /// arguments must outlive this object.
  Packet(const SceneView& scene, const RayBatch& rays, std::uint8_t* occluded,
         const ResolvedFilter* resolved, TraceCounts& counts)
      : tree_(*scene.tree().trees[scene.tree().placements[0].tree]),
        rays_(rays),
        occluded_(occluded),
        counts_(counts),
        preparation_(scene.tree().bounds, tree_.scale_exponent),
        scale_(power_of_two(tree_.scale_exponent)),
        hits_(scene, rays, resolved, counts) {
    hits_.enter(0);
  }

  /// Sets up rays from `first` on. At least kNarrowRays rays must exist, and kPacketRays if `most`
  /// is larger than kNarrowRays; at most `most` of them belong to the packet. Returns how many form
  /// a packet; if they are fewer than kFewestRays, they must not be traced as a packet.
  std::size_t prepare(std::size_t first, std::size_t most) {
    first_ = first;
    lanes_ = is_wide_ && most > kNarrowRays ? kPacketRays : kNarrowRays;
    for (LaneBits& bits : columns_.negative) bits = 0;
    columns_.largest_x = columns_.largest_y = 0;
    constexpr std::size_t kStep = hn::MaxLanes(GroupPreparation::D());
    LaneBits alike = 0;
    fetch_rays(rays_, first + kPacketRays, lanes_);
    for (std::size_t i = 0; i < lanes_; i += kStep) {
      alike |= LaneBits{preparation_.prepare_columns(rays_, first + i, i, columns_)} << i;
    }
    // One octant, one largest axis: those of the first ray.
    for (const LaneBits bits : {columns_.negative[0], columns_.negative[1], columns_.negative[2],
                                columns_.largest_x, columns_.largest_y})
      alike &= (bits & 1u) != 0 ? bits : ~bits;
    // No ray goes in the lanes from lanes_ on: their bits are not set.
    const auto count = std::min(static_cast<std::size_t>(std::countr_one(alike)), most);
    if (count < kFewestRays) return count;
    if (count <= kNarrowRays) lanes_ = kNarrowRays;
    if (count < lanes_) repeat_first(count);
    hits_.start(first, columns_.tau_max, lanes_);
    for (std::size_t i = count; i < lanes_; ++i) hits_.exclude(i, -1 / scale_);
    axes_ = columns_.filter(0);
    reach_ = most_of(GroupPreparation::D(), columns_.reach, lanes_);
    has_vertex_culling_ = vertex_culling_.set(columns_, lanes_, reach_);
    interval_culling_.set(columns_, lanes_, has_vertex_culling_, set_limits());
    count_ = count;
    return count;
  }

  /// Traces the rays of prepare(). Calls finish.add(ray, candidate) for each closest hit, or
  /// finish.add_neighbours (GroupHits::hand_over); if kAny, sets occluded[ray] to 1 or 0. Returns
  /// true if the packet took fewer steps than its rays would have taken one by one.
  template <class Finish>
  bool trace(Finish& finish) {
    steps_ = ray_steps_ = 0;
    walk();
    if constexpr (kAny) {
      for (std::size_t i = 0; i < count_; ++i) occluded_[first_ + i] = limit_[i] == -kInfF ? 1 : 0;
    } else {
      hits_.hand_over(count_, finish);
    }
    counts_.nodes += ray_steps_;
    counts_.packet_rays += count_;
    is_wide_ = thresholds::kFewestPerStepIfWide * steps_ * count_ <= ray_steps_ * kNarrowRays;
    return steps_ < ray_steps_;
  }

  /// Traces the rays without reporting hits, and stops early if the result is clear. Returns true
  /// if on average more than `fewest_per_step` rays are active at a node or box.
  bool try_out(double fewest_per_step) {
    steps_ = ray_steps_ = 0;
    steps_to_try_ = kStepsToTry;
    walk();
    steps_to_try_ = ~std::uint64_t{0};
    counts_.nodes += ray_steps_;
    return fewest_per_step * static_cast<double>(steps_) < static_cast<double>(ray_steps_);
  }
  /// Steps of the last trace() or try_out(): nodes opened and boxes tested for the packet.
  std::uint64_t steps() const { return steps_; }
  /// Nodes that the rays of that packet would have visited one by one.
  std::uint64_t ray_steps() const { return ray_steps_; }

 private:
  static constexpr std::uint64_t kStepsToTry = 48;  ///< a trial does not end before so many steps

  /// The stack: children that are to be visited.
  struct Waiting {
    HWY_ALIGN std::uint32_t parent[kWaiting];
    HWY_ALIGN std::uint32_t slot[kWaiting];
    HWY_ALIGN float near[kWaiting];     ///< entry distance of the packet's interval
    HWY_ALIGN LaneBits rays[kWaiting];  ///< rays that met the parent
  };

  /// Fills the lanes from `count` on with copies of the first ray, which do not widen the interval.
  void repeat_first(std::size_t count) {
    for (std::size_t i = count; i < lanes_; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        columns_.near_origin[k][i] = columns_.near_origin[k][0];
        columns_.far_origin[k][i] = columns_.far_origin[k][0];
        columns_.near_inverse[k][i] = columns_.near_inverse[k][0];
        columns_.far_inverse[k][i] = columns_.far_inverse[k][0];
        columns_.origin[k][i] = columns_.origin[k][0];
      }
      columns_.shear_x[i] = columns_.shear_x[0];
      columns_.shear_y[i] = columns_.shear_y[0];
      columns_.box_min[i] = columns_.box_min[0];
      columns_.reach[i] = columns_.reach[0];
      columns_.tau_max[i] = columns_.tau_max[0];
    }
  }

  void walk() {
    if (ChildRef::is_leaf(tree_.root)) {
      visit_leaf(tree_.root, ~LaneBits{0} >> (64 - count_));
      return;
    }
    std::size_t size = expand(tree_.root, 0, ~LaneBits{0} >> (64 - count_));
    ray_steps_ += count_;
    while (size > 0) {
      --size;
      if (!(waiting_.near[size] <= interval_culling_.limit())) continue;
      const WideNode& parent = tree_.node(waiting_.parent[size]);
      const std::uint32_t slot = waiting_.slot[size];
      const std::uint32_t ref = parent.child[slot];
      const LaneBits met =
          interval_culling_.rays_that_meet(parent, slot, columns_, limit_, waiting_.rays[size]);
      ++steps_;
      ++counts_.packet_boxes;
      if (met == 0) continue;
      if (ChildRef::is_leaf(ref)) {
        visit_leaf(ref, met);
      } else {
        if (HWY_UNLIKELY(steps_ > steps_to_try_) && ray_steps_ < steps_) return;
        size = expand(ref, size, met);
        ray_steps_ += static_cast<std::uint64_t>(std::popcount(met));
      }
    }
  }

  /// Pushes the children of a node that the interval meets, the nearest last.
  HWY_INLINE std::size_t expand(std::uint32_t ref, std::size_t size, LaneBits rays) {
    const hn::CappedTag<std::uint32_t, kArity> du;
    ++steps_;
    ++counts_.packet_nodes;
    for (std::size_t i = 0; i < kArity; i += hn::Lanes(du))
      hn::StoreU(hn::Set(du, ref), du, waiting_.parent + size + i);
    const hn::CappedTag<LaneBits, kArity> dr;
    for (std::size_t i = 0; i < kArity; i += hn::Lanes(dr))
      hn::StoreU(hn::Set(dr, rays), dr, waiting_.rays + size + i);
    const WideNode& node = tree_.node(ref);
    const std::size_t more =
        interval_culling_.children(node, waiting_.slot + size, waiting_.near + size);
    for (std::size_t i = size; i < size + more; ++i)
      fetch_node(tree_.arena.at(ChildRef::granule(node.child[waiting_.slot[i]])));
    return size + more;
  }

  HWY_INLINE void visit_leaf(std::uint32_t ref, LaneBits met) {
    changed_ = false;
    ++counts_.packet_leaves;
    for (const LeafBlock& block : tree_.blocks(ref)) {
      if (met == 0) break;
      counts_.blocks += static_cast<std::uint64_t>(std::popcount(met));
      for (std::uint32_t first = 0; first < block.lane_count(); first += kPart)
        met = visit_part(block, first, met);
    }
    if (!changed_) return;
    if constexpr (kAny) {
      interval_culling_.set_limit(most_of(hn::CappedTag<float, kPacketRays>(), limit_, lanes_));
    } else {
      interval_culling_.set_limit(set_limits());
    }
  }

  /// Triangles of a block that one vector holds: four or two.
  static constexpr std::uint32_t kPart = hn::MaxLanes(FilterLanes());

  /// Filters the triangles of a block from `first` on, as many as a vector has lanes. Returns the
  /// rays that are still active.
  HWY_INLINE LaneBits visit_part(const LeafBlock& block, std::uint32_t first, LaneBits met) {
    const Placement& placement = hits_.placement(block);
    const LaneCorners<FilterLanes> corners = load_corners<kPlaced>(block, first, axes_, placement);
    const double edge = largest_edge<kPlaced>(block, placement);
    const std::uint32_t lanes = std::min(kPart, block.lane_count() - first);
    const bool many = is_full(met, static_cast<std::uint32_t>(std::popcount(met)), lanes);
    std::uint32_t triangles = (1u << lanes) - 1u;
    if (has_vertex_culling_ && vertex_culling_.suits(edge)) {
      const LaneEdges<FilterLanes> seen = vertex_culling_.see(corners);
      if (many) triangles &= vertex_culling_.triangles_that_may_be_met(corners, seen);
      return many ? many_rays(block, first, seen, triangles, edge, met)
                  : few_rays(block, first, seen, edge, met);
    }
    return many ? many_rays(block, first, corners, triangles, edge, met)
                : few_rays(block, first, corners, edge, met);
  }

  /// True if filtering many rays per vector uses at least three quarters of the lanes that
  /// filtering `triangles` triangles per vector would use.
  bool is_full(LaneBits met, std::uint32_t count, std::uint32_t triangles) const {
    constexpr auto kWide = static_cast<std::uint32_t>(hn::MaxLanes(GroupPreparation::D()));
    std::uint32_t room = 0;
    for (std::size_t i = 0; i < lanes_; i += kWide)
      room += (met >> i & ((1u << kWide) - 1u)) != 0 ? kWide : 0;
    return thresholds::kFullOf * kPart * count >= thresholds::kFullRays * triangles * room;
  }

  /// Filters each ray with kPart triangles at a time. Returns the rays that are still active.
  template <class Triangles>
  HWY_INLINE LaneBits few_rays(const LeafBlock& block, std::uint32_t first,
                               const Triangles& triangles, double edge, LaneBits met) {
    for (LaneBits rest = met; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(rest));
      LeafVerdict verdict;
      filter_triangles<Pace::kLatency>(triangles, edge, columns_.filter(i), reach_, hits_.bound(i),
                                       first, verdict);
      if (!verdict.keep_lanes_of(block) || !hits_.does_count(i, block, verdict)) continue;
      changed_ = true;
      if constexpr (kAny) {
        if (verdict.accept != 0 || hits_.examine_any_of(i, block, verdict.examine))
          met &= ~leave(i);
      } else {
        hits_.take_closest(i, block, verdict);
      }
    }
    return met;
  }

  /// Filters each triangle of the bit set `some` with as many rays at a time as a vector has lanes.
  /// Returns the rays that are still active.
  template <class Triangles>
  HWY_INLINE LaneBits many_rays(const LeafBlock& block, std::uint32_t first,
                                const Triangles& triangles, std::uint32_t some, double edge,
                                LaneBits met) {
    const GroupPreparation::D dd;
    const OneByOne one_by_one(triangles);
    for (; some != 0; some &= some - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(some));
      const std::uint8_t sides = hits_.counting_sides(block, first + lane);
      if (sides == 0) continue;
      const auto triangle = one_by_one.in_every_lane(dd, lane);
      for (std::size_t i = 0; i < lanes_; i += hn::Lanes(dd)) {
        const auto wanted = static_cast<std::uint32_t>(met >> i) & ((1u << hn::Lanes(dd)) - 1u);
        if (wanted == 0) continue;
        LaneVerdicts<GroupPreparation::D> found;
        if (!filter_lanes<Pace::kLatency>(dd, triangle, edge, load_rays(i), reach_, found))
          continue;
        std::uint32_t left = mask_bits(dd, found.left) & wanted;
        if (left == 0) continue;
        left = hits_.counting_rays(sides, block, first + lane, i, found, left);
        if (left == 0) continue;
        const std::uint32_t certain = mask_bits(dd, found.certain) & left;
        changed_ = true;
        if constexpr (kAny) {
          met &= ~some_leave(block, first + lane, i, certain, left & ~certain);
        } else {
          hits_.take_nearer(block, first + lane, i, found, certain, left & ~certain);
        }
      }
    }
    return met;
  }

  HWY_INLINE LaneRays<GroupPreparation::D> load_rays(std::size_t i) const {
    const GroupPreparation::D dd;
    const auto& c = columns_;
    const auto tau_min = hn::Load(dd, c.tau_min + i);
    return {{hn::Load(dd, c.origin[0] + i), hn::Load(dd, c.origin[1] + i),
             hn::Load(dd, c.origin[2] + i)},
            hn::Load(dd, c.shear_x + i),
            hn::Load(dd, c.shear_y + i),
            hn::Load(dd, c.inverse_z + i),
            tau_min,
            tau_min,
            hn::Load(dd, c.tau_max + i),
            hn::Load(dd, hits_.bounds() + i)};
  }

  /// Ends rays of "any" that have a hit; returns their bits in the packet.
  HWY_INLINE LaneBits some_leave(const LeafBlock& block, std::uint32_t lane, std::size_t first,
                                 std::uint32_t certain, std::uint32_t examine) {
    LaneBits left = 0;
    for (std::uint32_t rest = certain | examine; rest != 0; rest &= rest - 1) {
      const auto j = static_cast<std::uint32_t>(std::countr_zero(rest));
      const auto i = static_cast<std::uint32_t>(first) + j;
      if ((certain >> j & 1u) != 0 || hits_.examine_any_of(i, block, 1u << lane)) left |= leave(i);
    }
    return left;
  }
  LaneBits leave(std::uint32_t i) {
    limit_[i] = -kInfF;  // the ray meets no box any more
    return LaneBits{1} << i;
  }

  /// Sets all limits from the bounds of the hits, as BoxRay::limit does. Returns the largest limit.
  HWY_INLINE float set_limits() {
    const GroupPreparation::D dd;
    const hn::Rebind<float, GroupPreparation::D> df;
    const auto limits_from = [&](std::size_t i) {
      const auto tau = hn::Mul(hn::Load(dd, hits_.bounds() + i), hn::Set(dd, scale_));
      const auto step = hn::MulAdd(hn::Abs(tau), hn::Set(dd, bounds::kLimitStep),
                                   hn::Set(dd, bounds::kLimitFloor));
      // What is infinite stays so; bounds of a packet's rays are never NaN or minus infinity.
      return to_float32(df, hn::Add(tau, step));
    };
    auto most = hn::Set(df, -kInfF);
    for (std::size_t i = 0; i < lanes_; i += 2 * hn::Lanes(dd)) {
      const auto low = limits_from(i), high = limits_from(i + hn::Lanes(dd));
      store_pair(df, low, high, limit_ + i);
      most = hn::Max(most, hn::Max(low, high));
    }
    return hn::GetLane(hn::MaxOfLanes(df, most));
  }

  const WideTree& tree_;
  const RayBatch& rays_;
  std::uint8_t* occluded_;
  TraceCounts& counts_;
  GroupPreparation preparation_;
  double scale_;
  std::size_t first_ = 0, count_ = 0;
  std::size_t lanes_ = kNarrowRays;  ///< count_ rounded up to kNarrowRays or kPacketRays
  /// the last packet's rays visited many nodes in common, so the next may be wide
  bool is_wide_ = false;
  PreparedColumns<kPacketRays> columns_;
  GroupHits<kPacketRays> hits_;
  HWY_ALIGN float limit_[kPacketRays];  ///< limits of the rays; minus infinity: the ray is finished
  bool changed_ = false;                ///< some limit may have changed since the last check
  FilterRay axes_;                      ///< its kx, ky, kz are those of all rays
  double reach_ = 0;                    ///< at least the reach of every ray
  IntervalCulling<kPacketRays> interval_culling_;
  VertexCulling<kPacketRays> vertex_culling_;
  bool has_vertex_culling_ = false;  ///< all rays start at one point
  Waiting waiting_;
  std::uint64_t steps_to_try_ = ~std::uint64_t{0};
  std::uint64_t steps_ = 0;  ///< steps of the packet: nodes opened and boxes tested for all rays
  std::uint64_t ray_steps_ = 0;  ///< nodes that the rays would have visited in single traversals
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
