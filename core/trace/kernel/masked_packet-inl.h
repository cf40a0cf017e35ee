// Masked packets over instances [Wald2001]: up to 32 neighbouring rays traverse the top tree as one
// packet. Inside of a placement only the rays that meet it are active, and their directions need
// not be similar.
//
//   node    all rays that are active at the node test each of its eight boxes
//   stack   children that some ray meets, with the entry distance of each ray
//   leaf    the corners of a block are mapped to world space once for all rays that meet its box
//
// If rays diverge, this is slower than interleaved traversal; the packet counts the steps of both.

#if defined(SIGHTLINE_TRACE_MASKED_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_MASKED_PACKET_INL_H_
#undef SIGHTLINE_TRACE_MASKED_PACKET_INL_H_
#else
#define SIGHTLINE_TRACE_MASKED_PACKET_INL_H_
#endif

#include <bit>
#include <limits>

#include "core/geometry/rounding.h"
#include "core/trace/kernel/enter-inl.h"
#include "core/trace/kernel/group_hits-inl.h"
#include "core/trace/kernel/slabs-inl.h"
#include "core/trace/kernel/thresholds.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Rays of a masked packet.
constexpr std::size_t kMaskedPacketRays = 32;

/// A masked packet, for scenes of several entries. Call prepare(), then trace() if it returned
/// rays. A packet serves one call after the other.
template <bool kAny>
class MaskedPacket {
 public:
  /// `resolved`: which triangles count; null: all. `occluded` is written if kAny, else null. All
  /// arguments must outlive this object.
  MaskedPacket(const SceneView& scene, const RayBatch& rays, std::uint8_t* occluded,
               const ResolvedFilter* resolved, TraceCounts& counts)
      : tree_(scene.tree()),
        bounds_(tree_.bounds),
        rays_(rays),
        occluded_(occluded),
        counts_(counts),
        preparation_(tree_.bounds, tree_.top.scale_exponent),
        hits_(scene, rays, resolved, counts) {
    for (double& scale : top_.tau_scale) scale = power_of_two(tree_.top.scale_exponent);
    for (double& scale : inner_.tau_scale) scale = 1;
  }

  /// Sets up the kMaskedPacketRays rays from `first` on, which must exist. Returns how many of them
  /// form a packet: all or none.
  std::size_t prepare(std::size_t first, std::size_t /*most*/ = kMaskedPacketRays) {
    first_ = first;
    for (LaneBits& bits : columns_.negative) bits = 0;
    columns_.largest_x = columns_.largest_y = 0;
    std::uint32_t good = 0;
    fetch_rays(rays_, first + 2 * kMaskedPacketRays, kMaskedPacketRays);
    for (std::size_t i = 0; i < kMaskedPacketRays; i += hn::MaxLanes(DoubleLanes()))
      good |= preparation_.prepare_columns(rays_, first + i, i, columns_) << i;
    if (good != kAllRays) return 0;
    bool exact = true;
    for (std::size_t i = 0; i < kMaskedPacketRays; ++i)
      exact &= anchored_.set_direction(
          i, {rays_.dx[first + i], rays_.dy[first + i], rays_.dz[first + i]});
    if (!exact) return 0;
    anchored_.origin[0] = &rays_.ox[first];
    anchored_.origin[1] = &rays_.oy[first];
    anchored_.origin[2] = &rays_.oz[first];
    anchored_.tau_min = columns_.tau_min;
    reach_ = most_of(DoubleLanes(), columns_.reach, kMaskedPacketRays);
    hits_.start(first, columns_.tau_max, kMaskedPacketRays);
    return kMaskedPacketRays;
  }

  /// Traces the rays of prepare(). Calls finish.add(ray, candidate) for each closest hit, or sets
  /// occluded[ray] if kAny. Returns true if on average more than thresholds::kFewestPerNode rays
  /// were active at a node: then packets are faster than interleaved traversal.
  template <class Finish>
  bool trace(Finish& finish) {
    steps_ = ray_steps_ = 0;
    looking_ = kAllRays;
    top_.set_octant(columns_, kAllRays);
    top_.set_limits(hits_);
    start(0, columns_, kAllRays);
    walk<true>(tree_.top, columns_, top_, 0);
    if constexpr (kAny) {
      for (std::size_t i = 0; i < kMaskedPacketRays; ++i)
        occluded_[first_ + i] = (looking_ >> i & 1u) != 0 ? 0 : 1;
    } else {
      hits_.hand_over(kMaskedPacketRays, finish);
    }
    counts_.nodes += ray_steps_;
    counts_.packet_rays += kMaskedPacketRays;
    return thresholds::kFewestPerNode * steps_ < ray_steps_;
  }

 private:
  using D = hn::CappedTag<float, kMaskedPacketRays>;
  using DoubleLanes = GroupPreparation::D;
  using Slabs = SlabColumns<kMaskedPacketRays>;
  static constexpr std::size_t kVectors = kMaskedPacketRays / hn::MaxLanes(D());
  static constexpr std::uint32_t kAllRays = ~0u >> (32 - kMaskedPacketRays);

  /// The rays' limits (BoxRay::limit) in the units of a tree, and the octant of most rays.
  struct Space {
    HWY_ALIGN double tau_scale[kMaskedPacketRays];
    HWY_ALIGN float limit[kMaskedPacketRays];
    std::uint32_t octant = 0;

    void set_octant(const Slabs& slabs, std::uint32_t rays) {
      octant = 0;
      for (std::uint32_t k = 0; k < 3; ++k)
        octant |= 2 * std::popcount(slabs.negative[k] & rays) > std::popcount(rays) ? 1u << k : 0;
    }
    /// Sets all limits from the bounds of the hits, as BoxRay::limit does.
    void set_limits(const GroupHits<kMaskedPacketRays>& hits) {
      const DoubleLanes dd;
      const hn::Rebind<float, DoubleLanes> df;
      for (std::size_t i = 0; i < kMaskedPacketRays; i += hn::Lanes(dd)) {
        const auto tau = hn::Mul(hn::Load(dd, hits.bounds() + i), hn::Load(dd, tau_scale + i));
        const auto step = hn::MulAdd(hn::Abs(tau), hn::Set(dd, bounds::kLimitStep),
                                     hn::Set(dd, bounds::kLimitFloor));
        const auto up = to_float32(df, hn::Add(tau, step));
        hn::Store(hn::IfThenElse(hn::IsNaN(up), hn::Set(df, kInfF), up), df, limit + i);
      }
    }
  };

  /// Puts the root of a tree on the stack. Its entry distance is set for the rays of `rays`; it is
  /// NaN for the others, so that they pass no comparison in this tree.
  void start(std::size_t at, const Slabs& slabs, std::uint32_t rays) {
    for (std::size_t i = 0; i < kMaskedPacketRays; ++i)
      near_[at][i] =
          (rays >> i & 1u) != 0 ? slabs.box_min[i] : std::numeric_limits<float>::quiet_NaN();
  }

  /// Traverses a tree from the root, which is the element `base` of the stack.
  template <bool kTop>
  void walk(const WideTree& tree, const Slabs& slabs, Space& space, std::size_t base) {
    const D d;
    std::size_t size = base + 1;
    ref_[base] = tree.root;
    while (size > base) {
      --size;
      const std::uint32_t ref = ref_[size];
      std::uint32_t met = 0;
      for (std::size_t i = 0; i < kMaskedPacketRays; i += hn::Lanes(d))
        met |= mask_bits(d, hn::Le(hn::Load(d, near_[size] + i), hn::Load(d, space.limit + i)))
               << i;
      if constexpr (kAny) met &= looking_;
      if (met == 0) continue;
      if (size > base) fetch_node(tree.arena.at(ChildRef::granule(ref_[size - 1])));
      if (!ChildRef::is_leaf(ref)) {
        ++steps_;
        ++counts_.packet_nodes;
        ray_steps_ += static_cast<std::uint32_t>(std::popcount(met));
        size = expand(tree.node(ref), slabs, space, met, size);
      } else if constexpr (kTop) {
        enter_all(ref, met, size);
      } else {
        visit_leaf(tree, ref, met, space);
      }
    }
  }

  /// Replaces a node, the top element of the stack, by those of its children that a ray of `met`
  /// meets, the first to visit last.
  HWY_INLINE std::size_t expand(const WideNode& node, const Slabs& slabs, const Space& space,
                                std::uint32_t met, std::size_t size) {
    const D d;
    const auto nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
    hn::Vec<D> entered[kVectors];
    SIGHTLINE_UNROLL
    for (std::size_t v = 0; v < kVectors; ++v)
      entered[v] = hn::Load(d, near_[size] + v * hn::Lanes(d));
    std::uint32_t order = kAny ? 076543210u : node.order[space.octant];
    for (std::size_t child = 0; child < kArity; ++child, order >>= 3) {
      const std::uint32_t slot = order & 7u;
      bool none = true;
      SIGHTLINE_UNROLL
      for (std::size_t v = 0; v < kVectors; ++v) {
        const std::size_t i = v * hn::Lanes(d);
        if (kVectors > 1 && (met >> i & (~0u >> (32 - hn::Lanes(d)))) == 0) {
          hn::Store(nan, d, near_[size] + i);
          continue;
        }
        auto near = entered[v];
        auto far = hn::Load(d, space.limit + i);
        SIGHTLINE_UNROLL
        for (std::size_t k = 0; k < 3; ++k) {
          const auto far_inverse = hn::Load(d, slabs.far_inverse[k] + i);
          const auto negative = hn::Lt(far_inverse, hn::Zero(d));
          const auto lower = hn::Set(d, node.lower[k][slot]);
          const auto upper = hn::Set(d, node.upper[k][slot]);
          const auto before = hn::Sub(hn::IfThenElse(negative, upper, lower),
                                      hn::Load(d, slabs.near_origin[k] + i));
          const auto behind =
              hn::Sub(hn::IfThenElse(negative, lower, upper), hn::Load(d, slabs.far_origin[k] + i));
          near = max_unless_nan(d, hn::Mul(before, hn::Load(d, slabs.near_inverse[k] + i)), near);
          far = min_unless_nan(d, hn::Mul(behind, far_inverse), far);
        }
        const auto hit = hn::Le(near, far);
        hn::Store(hn::IfThenElse(hit, near, nan), d, near_[size] + i);
        none &= hn::AllFalse(d, hit);
      }
      ref_[size] = node.child[slot];
      size += none ? 0 : 1;
    }
    return size;
  }

  /// Enters the placements of a leaf of the top tree; `size` elements of the stack are in use.
  HWY_NOINLINE void enter_all(std::uint32_t ref, std::uint32_t met, std::size_t size) {
    for (const LeafBlock& block : tree_.top.blocks(ref)) {
      for (std::uint32_t i = 0; i < block.lane_count(); ++i) {
        if constexpr (kAny) met &= looking_;
        enter(block.triangle(i), met, size);
      }
    }
    if constexpr (!kAny) top_.set_limits(hits_);
  }

  void enter(std::uint32_t number, std::uint32_t met, std::size_t size) {
    const Placement& placement = tree_.placements[number];
    const WideTree& tree = *tree_.trees[placement.tree];
    counts_.placements += static_cast<std::uint32_t>(std::popcount(met));
    hits_.enter(number);
    if (placement.world_boxes && tree.scale_exponent == tree_.top.scale_exponent) {
      if constexpr (!kAny) top_.set_limits(hits_);
      start(size, columns_, met);
      walk<false>(tree, columns_, top_, size);
      return;
    }
    map(placement, tree.scale_exponent, met);
    inner_.set_octant(inner_slabs_, met);
    inner_.set_limits(hits_);
    start(size, inner_slabs_, met);
    walk<false>(tree, inner_slabs_, inner_, size);
  }

  void map(const Placement& placement, int scale_exponent, std::uint32_t met) {
    const DoubleLanes dd;
    for (LaneBits& bits : inner_slabs_.negative) bits = 0;
    std::uint32_t good = 0;
    if (!placement.world_boxes) {
      for (std::size_t i = 0; i < kMaskedPacketRays; i += hn::Lanes(dd)) {
        if ((met >> i & ((1u << hn::Lanes(dd)) - 1u)) == 0) continue;
        good |= map_lanes(dd, anchored_, i, placement.space, power_of_two(scale_exponent),
                          inner_slabs_, inner_.tau_scale)
                << i;
      }
    }
    for (std::uint32_t rest = met & ~good; rest != 0; rest &= rest - 1)
      map_one(placement, scale_exponent, static_cast<std::uint32_t>(std::countr_zero(rest)));
  }

  /// Maps one ray, if map_lanes could not.
  HWY_NOINLINE void map_one(const Placement& placement, int scale_exponent, std::uint32_t i) {
    const AnchoredRay ray = anchor_ray(rays_[first_ + i], bounds_);
    const BoxRay box = placement.world_boxes ? make_box_ray(ray, scale_exponent)
                                             : make_box_ray(ray, placement.space, scale_exponent);
    for (std::size_t k = 0; k < 3; ++k) {
      inner_slabs_.near_origin[k][i] = box.near_origin[k];
      inner_slabs_.far_origin[k][i] = box.far_origin[k];
      inner_slabs_.near_inverse[k][i] = box.near_inverse[k];
      inner_slabs_.far_inverse[k][i] = box.far_inverse[k];
    }
    inner_slabs_.box_min[i] = box.tau_min;
    inner_.tau_scale[i] = box.tau_scale;
  }

  HWY_INLINE void visit_leaf(const WideTree& tree, std::uint32_t ref, std::uint32_t met,
                             Space& space) {
    bool changed = false;
    ++counts_.packet_leaves;
    for (const LeafBlock& block : tree.blocks(ref)) {
      if constexpr (kAny) met &= looking_;
      counts_.blocks += static_cast<std::uint32_t>(std::popcount(met));
      changed |= filter_rays(block, met);
    }
    if (!kAny && changed) space.set_limits(hits_);
  }

  /// Filters each ray with four triangles at a time. Returns true if the limit of some ray may have
  /// changed.
  HWY_INLINE bool filter_rays(const LeafBlock& block, std::uint32_t met) {
    const FilterLanes d4;
    const Placement& placement = hits_.placement(block);
    const double edge = largest_edge<true>(block, placement);
    FilterRay world{};
    world.ky = 1;
    world.kz = 2;
    HWY_ALIGN double corner[3][3][kLanes];  // by axis
    for (std::size_t j = 0; j < kLanes; j += hn::Lanes(d4)) {
      const LaneCorners<FilterLanes> placed = load_corners<true>(block, j, world, placement);
      SIGHTLINE_UNROLL
      for (std::size_t c = 0; c < 3; ++c) {
        hn::Store(placed.x[c], d4, corner[0][c] + j);
        hn::Store(placed.y[c], d4, corner[1][c] + j);
        hn::Store(placed.z[c], d4, corner[2][c] + j);
      }
    }
    bool changed = false;
    for (std::uint32_t rest = met; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(rest));
      const FilterRay ray = columns_.filter(i);
      LeafVerdict verdict;
      for (std::size_t j = 0; j < kLanes; j += hn::Lanes(d4)) {
        LaneCorners<FilterLanes> corners;
        SIGHTLINE_UNROLL
        for (std::size_t c = 0; c < 3; ++c) {
          corners.x[c] = hn::Load(d4, corner[ray.kx][c] + j);
          corners.y[c] = hn::Load(d4, corner[ray.ky][c] + j);
          corners.z[c] = hn::Load(d4, corner[ray.kz][c] + j);
        }
        filter_triangles<Pace::kLatency>(corners, edge, ray, reach_, hits_.bound(i), j, verdict);
      }
      if (!verdict.keep_lanes_of(block) || !hits_.does_count(i, block, verdict)) continue;
      changed = true;
      if constexpr (kAny) {
        if (verdict.accept != 0 || hits_.examine_any_of(i, block, verdict.examine))
          looking_ &= ~(1u << i);
      } else {
        hits_.take_closest(i, block, verdict);
      }
    }
    return changed;
  }

  const SceneTree& tree_;
  const Box3d& bounds_;
  const RayBatch& rays_;
  std::uint8_t* occluded_;
  TraceCounts& counts_;
  GroupPreparation preparation_;
  std::size_t first_ = 0;
  PreparedColumns<kMaskedPacketRays>
      columns_;  ///< slabs in the units of the tree over the placements
  AnchoredColumns<kMaskedPacketRays> anchored_;
  Slabs inner_slabs_;  ///< in the space of the entered placement
  Space top_, inner_;
  GroupHits<kMaskedPacketRays> hits_;
  std::uint32_t looking_ = 0;  ///< rays of "any" that have met nothing yet
  double reach_ = 0;           ///< at least the reach of every ray
  std::uint32_t ref_[kWaiting];
  HWY_ALIGN float near_[kWaiting][kMaskedPacketRays];
  std::uint64_t steps_ = 0;      ///< nodes opened
  std::uint64_t ray_steps_ = 0;  ///< nodes that the rays would have visited one by one
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
