// Interleaved traversal: many rays in flight on one thread, so that other rays compute while a ray
// waits for memory. The technique is asynchronous memory access chaining [Kocberber2015]. A slot
// holds the state of a ray in flight.
//
//   prepared -> slot: node queue <-> leaf queue -> finished -> TRounding -> hits
//                 \___ every round: each ray one node or one leaf ___/
//
// A single ray waits for memory at every step. Here a ray that has chosen its next node prefetches
// it, and all other rays in flight make a step before it continues. The inner step has no branch
// that depends on the ray: the queue for its next step is computed by arithmetic.
//
// A round has two passes: first all arithmetic, then everything that depends on its outcome. An
// out-of-order processor overlaps three or four steps of the first pass. None of them waits for
// another or is discarded by a mispredicted branch.

#if defined(SIGHTLINE_TRACE_INTERLEAVED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_INTERLEAVED_INL_H_
#undef SIGHTLINE_TRACE_INTERLEAVED_INL_H_
#else
#define SIGHTLINE_TRACE_INTERLEAVED_INL_H_
#endif

#include <hwy/cache_control.h>

#include <bit>
#include <span>
#include <type_traits>

#include "core/geometry/rounding.h"
#include "core/trace/decision.h"
#include "core/trace/kernel/enter-inl.h"
#include "core/trace/kernel/filter-inl.h"
#include "core/trace/kernel/kernel.h"
#include "core/trace/kernel/prepare-inl.h"
#include "core/trace/kernel/round_t-inl.h"
#include "core/trace/kernel/slabs-inl.h"
#include "core/trace/kernel/thresholds.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

constexpr std::size_t kRaysAhead = 64;  ///< rays are prefetched so many rays before they start
/// The deadline is checked once in so many rounds. A round is a step of every ray in flight.
constexpr std::uint32_t kRoundsBetweenLooks = 128;
/// Scenes with deeper trees are traced by the single-ray kernel, because the stack of a slot is
/// short.
constexpr std::uint32_t kMaxInterleavedDepth = (kWaiting - kArity - 2) / (kArity - 1);

/// The place of a ray in a scene of several entries: in the top tree, or in the tree of an entry.
struct Whereabouts {
  std::uint32_t at_top;        ///< 1: the ray is in the top tree
  const std::byte* base;       ///< arena of the tree in which the ray is
  const Placement* placement;  ///< the entry in which the ray is, or that is being fetched
  std::uint32_t arriving;      ///< 1: the placement is being fetched
  std::uint32_t first;         ///< index on the stack of the first element of the present tree
};
/// The ray as the top tree has it, from which it enters entries.
struct TopRay {
  AnchoredRay anchored;  ///< is mapped into the trees of entries
  BoxRay box;            ///< the ray in the units of the top tree
};
/// Takes the place of Whereabouts and TopRay in a scene of one entry.
struct Nowhere {};

/// Neighbouring rays that are set up in one step: `count` rays, at most kGroupRays, from `first`
/// on.
struct RayGroup {
  std::uint32_t first;
  std::uint32_t count;
};

/// Traces rays of a batch for closest hits (or any hits if kAny), with kInFlight rays in flight.
/// Construct it once for a batch, then call run() for some groups of rays at a time. The scene's
/// depth must not exceed kMaxInterleavedDepth.
template <bool kAny, Layout kLayout>
class Interleaved {
  static constexpr bool kPlaced = kLayout != Layout::kAsItIs;
  static constexpr bool kMany = kLayout == Layout::kMany;
  static constexpr std::size_t kInFlightMany =
      HWY_MAX_BYTES == 64 ? thresholds::kInFlightManyAvx512 : thresholds::kInFlightMany;
  static constexpr std::size_t kInFlight = kMany ? kInFlightMany : thresholds::kInFlight;
  static constexpr Wanted kWanted = kAny ? Wanted::kAny : Wanted::kNearest;
  /// "any" needs no intervals of tau.
  using Verdict = std::conditional_t<kAny, LeafBits, LeafVerdict>;

 public:
  /// `resolved`: which triangles count; null: all. `occluded` is written if kAny, else null. All
  /// arguments must outlive this object.
  Interleaved(const SceneView& scene, const RayBatch& rays, std::uint8_t* occluded,
              const ResolvedFilter* resolved, TraceCounts& counts)
      : scene_(scene),
        tree_(scene.tree()),
        root_(root_of(scene.tree())),
        base_(root_.arena.at(0)),
        placements_(scene.tree().placements.data()),
        rays_(rays),
        occluded_(occluded),
        resolved_(resolved),
        counts_(counts),
        preparation_(tree_.bounds, root_.scale_exponent) {}

  /// Traces the rays of the groups. Calls finish.add(ray, candidate) for each closest hit, ray
  /// being the index in the batch; if kAny, sets occluded[ray], which must be 0, to 1 for each hit
  /// instead. Stops early, with unusable results, if the deadline passes (TraceCounts::stopped).
  template <class Finish>
  void run(std::span<const RayGroup> groups, Finish& finish) {
    groups_ = groups;
    fly(finish);
  }

 private:
  static const WideTree& root_of(const SceneTree& tree) {
    return tree.entries > 1 ? tree.top : *tree.trees[tree.placements[0].tree];
  }

  /// State of one of the rays that are traversed in turn. A free slot takes the next ray. The step
  /// of a node uses the first cache lines and the top of the stack: slots that need fewer lines are
  /// faster (docs/decisions/0037).
  struct alignas(64) Slot {
    float limit;
    std::uint32_t waiting;  ///< number of elements on the stack, marks included
    std::uint32_t next;     ///< reference of the node or leaf that is being fetched
    [[no_unique_address]] std::conditional_t<kMany, Whereabouts, Nowhere> where;
    PreparedRay ray;
    ClosestHit best;
    std::size_t number;  ///< index of the ray in the batch
    [[no_unique_address]] std::conditional_t<kMany, TopRay, Nowhere> top;
    std::uint32_t ref[kWaiting];
    float near[kAny ? 1 : kWaiting];  ///< "any" needs none: no hit makes its limit smaller
  };

  /// Marks on the stack: kFinished at its bottom, kLeave below the elements of an entry's tree.
  /// Neither is a leaf or a granule of a tree.
  static constexpr std::uint32_t kFinished = 2u << ChildRef::kBlocksShift;
  static constexpr std::uint32_t kLeave = 3u << ChildRef::kBlocksShift;

  /// The kind of a ray's next step: a node, a leaf, finished, or a crossing between the top tree
  /// and an entry. A ray is put into the queue of its kind by index rather than by a branch,
  /// because the kind cannot be predicted.
  enum Class : std::uint8_t { kNode, kLeaf, kDone, kCross };
  /// The rays of one round, by class; each class has at most kInFlight.
  class Queues {
   public:
    Queues() { clear(); }
    Queues(const Queues&) = delete;  // end_ refers to slot_
    Queues& operator=(const Queues&) = delete;
    void clear() {
      for (std::size_t i = 0; i < 4; ++i) end_[i] = slot_[i];
    }
    std::uint32_t size(Class of) const { return static_cast<std::uint32_t>(end_[of] - slot_[of]); }
    HWY_INLINE Slot& at(Class of, std::size_t i) const { return *slot_[of][i]; }
    /// Adds a ray whose next step is the node, leaf or mark `next`.
    HWY_INLINE void add(Slot& taken, std::uint32_t next) {
      static constexpr std::uint8_t kClass[8] = {kNode, kNode, kDone, kCross,
                                                 kLeaf, kLeaf, kLeaf, kLeaf};
      std::uint32_t which = kClass[next >> ChildRef::kBlocksShift];
      // A leaf of the top tree is a crossing. No mark is met there but kFinished.
      if constexpr (kMany) which |= (which & taken.where.at_top) << 1;
      Slot** const to = end_[which];
      *to = &taken;
      end_[which] = to + 1;
    }

   private:
    Slot** end_[4];
    Slot* slot_[4][kInFlight];
  };

  /// Runs rounds until no ray is left, or until the deadline.
  template <class Finish>
  void fly(Finish& finish) {
    Queues a, b;
    Queues* now = &a;
    Queues* then = &b;
    for (std::size_t i = 0; i < kInFlight; ++i) free_[i] = &slots_[i];
    free_count_ = kInFlight;
    std::uint64_t nodes = 0, blocks = 0;
    for (std::uint32_t rounds = 1;; ++rounds) {
      if (rounds % kRoundsBetweenLooks == 0 && counts_.is_too_late()) break;
      // New rays start in groups: one group is set up in about the time of two single rays.
      while (!groups_.empty() && free_count_ >= kGroupRays) start_group(*now);
      const std::uint32_t node_count = now->size(kNode);
      const std::uint32_t leaf_count = now->size(kLeaf);
      const std::uint32_t done_count = now->size(kDone);
      const std::uint32_t cross_count = kMany ? now->size(kCross) : 0;
      if (node_count + leaf_count + done_count + cross_count == 0) break;
      nodes += node_count;
      blocks += leaf_count;
      for (std::uint32_t i = 0; i < node_count; ++i) {
        Slot& slot = now->at(kNode, i);
        const std::uint32_t waiting = slot.waiting;
        const auto& node = *reinterpret_cast<const WideNode*>(at(slot, slot.next));
        const auto found = static_cast<std::uint32_t>(
            push_children<kWanted>(node, slot.ray.box, slot.limit, slot.ref + waiting,
                                   kAny ? nullptr : slot.near + waiting));
        slot.waiting = waiting + found - 1;
      }
      for (std::uint32_t i = 0; i < leaf_count; ++i) filter(now->at(kLeaf, i), verdicts_[i]);
      if (HWY_UNLIKELY(resolved_ != nullptr)) {
        for (std::uint32_t i = 0; i < leaf_count; ++i) {
          if ((verdicts_[i].accept | verdicts_[i].examine) != 0)
            keep_counting(now->at(kLeaf, i), verdicts_[i]);
        }
      }
      for (std::uint32_t i = 0; i < node_count; ++i) {
        Slot& slot = now->at(kNode, i);
        proceed(slot, slot.ref[slot.waiting], *then);
      }
      for (std::uint32_t i = 0; i < leaf_count; ++i) {
        Slot& slot = now->at(kLeaf, i);
        const std::uint32_t granules = block_of(slot).granules();
        take(slot, verdicts_[i]);
        // A leaf of several blocks takes a round for each.
        const bool more = ChildRef::blocks(slot.next) > 1;
        const std::uint32_t rest = ChildRef::rest(slot.next, granules);
        const std::uint32_t popped = slot.ref[slot.waiting - 1];
        slot.waiting -= more ? 0 : 1;
        proceed(slot, more ? rest : popped, *then);
      }
      if constexpr (kMany) {
        for (std::uint32_t i = 0; i < cross_count; ++i) cross(now->at(kCross, i), *then);
      }
      for (std::uint32_t i = 0; i < done_count; ++i) {
        Slot& slot = now->at(kDone, i);
        if constexpr (!kAny) {
          if (slot.best.found()) finish.add(slot.number, slot.best.candidate);
        }
        free_[free_count_++] = &slot;
      }
      now->clear();
      std::swap(now, then);
    }
    counts_.nodes += nodes;
    counts_.blocks += blocks;
  }

  /// Puts the next group of rays into free slots.
  void start_group(Queues& queues) {
    const auto [first, count] = groups_.front();
    groups_ = groups_.subspan(1);
    PreparedRay* prepared[kGroupRays] = {};
    Slot* const* slots = free_ + (free_count_ - count);
    for (std::size_t i = 0; i < count; ++i) prepared[i] = &slots[i]->ray;
    fetch_rays(rays_, first + kRaysAhead, count);
    preparation_.prepare(rays_, first, count, prepared);
    for (std::size_t i = 0; i < count; ++i) {
      Slot& slot = *slots[i];
      slot.number = first + i;
      slot.best = ClosestHit(slot.ray.tau_max);
      slot.limit = slot.ray.box.limit(slot.ray.tau_max);
      slot.ref[0] = kFinished;
      slot.near[0] = -kInfF;
      slot.waiting = 1;
      if constexpr (kMany) {
        slot.top.anchored = anchored(rays_[slot.number], slot.ray, tree_.bounds);
        slot.top.box = slot.ray.box;
        slot.where.base = root_.arena.at(0);
        slot.where.at_top = slot.where.first = 1;
        slot.where.arriving = 0;
      }
      proceed(slot, root_.root, queues);
    }
    free_count_ -= count;
  }

  /// Moves a ray from the top tree into an entry, or back. A placement is fetched in one round and
  /// entered in the next.
  HWY_INLINE void cross(Slot& slot, Queues& queues) {
    Whereabouts& where = slot.where;
    if (slot.next == kLeave) {
      slot.ray.box = slot.top.box;
      where.base = root_.arena.at(0);
      where.at_top = where.first = 1;
      slot.limit = slot.ray.box.limit(slot.best.bound());
      if constexpr (!kAny) drop_farther(slot);
      proceed(slot, slot.ref[--slot.waiting], queues);
    } else if (where.arriving == 0) {
      const auto& block =
          *reinterpret_cast<const LeafBlock*>(at(slot, ChildRef::granule(slot.next)));
      where.placement = &tree_.placements[block.triangle(0)];
      where.arriving = 1;
      const auto* target = reinterpret_cast<const std::byte*>(where.placement);
      for (std::size_t i = 0; i < sizeof(Placement); i += 64) hwy::Prefetch(target + i);
      queues.add(slot, slot.next);
    } else {
      ++counts_.placements;
      const Placement& placement = *where.placement;
      const WideTree& tree = *tree_.trees[placement.tree];
      enter_placement(slot.top.anchored, placement, tree, root_, slot.top.box, slot.ray.box);
      slot.ref[slot.waiting] = kLeave;
      if constexpr (!kAny) slot.near[slot.waiting] = -kInfF;
      ++slot.waiting;
      where.base = tree.arena.at(0);
      where.at_top = where.arriving = 0;
      where.first = slot.waiting;
      slot.limit = slot.ray.box.limit(slot.best.bound());
      proceed(slot, tree.root, queues);
    }
  }

  /// Prefetches the next node or leaf of a ray and queues the ray for it.
  HWY_INLINE void proceed(Slot& slot, std::uint32_t next, Queues& queues) const {
    slot.next = next;
    const std::byte* target = at(slot, next & ChildRef::kGranuleMask);
    fetch_node(target);
    queues.add(slot, next);
  }
  HWY_INLINE const std::byte* at(const Slot& slot, std::uint32_t granule) const {
    if constexpr (kMany) return slot.where.base + std::size_t{granule} * Arena::kGranule;
    return base_ + std::size_t{granule} * Arena::kGranule;
  }
  /// The placement of a block of the tree in which the ray is.
  HWY_INLINE const Placement& placement(const Slot& slot, const LeafBlock& block) const {
    if constexpr (kMany) return slot.where.placement[block.placement()];
    return placements_[block.placement()];
  }
  /// The index on the stack where the ray's present tree begins.
  HWY_INLINE std::uint32_t first(const Slot& slot) const {
    if constexpr (kMany) return slot.where.first;
    return 1;
  }

  HWY_INLINE const LeafBlock& block_of(const Slot& slot) const {
    return *reinterpret_cast<const LeafBlock*>(at(slot, ChildRef::granule(slot.next)));
  }
  HWY_INLINE void filter(const Slot& slot, Verdict& verdict) const {
    const LeafBlock& block = block_of(slot);
    const auto judge = [&](LeafVerdict & whole) HWY_ATTR __attribute__((always_inline)) {
      filter_block<kPlaced, Pace::kThroughput>(block, slot.ray.filter, placement(slot, block),
                                               slot.best.bound(), whole);
    };
    if constexpr (kAny) {
      LeafVerdict whole;
      judge(whole);
      verdict = whole;
    } else {
      judge(verdict);
    }
  }
  HWY_INLINE void take(Slot& slot, const Verdict& verdict) {
    if ((verdict.accept | verdict.examine) == 0) return;
    const LeafBlock& block = block_of(slot);
    if constexpr (kAny) {
      if (meets_any(slot, block, verdict)) {
        occluded_[slot.number] = 1;
        slot.next = ChildRef::leaf(0, 1);  // nothing more of this leaf
        slot.waiting = 1;
      }
    } else {
      take_closest(slot, block, verdict);
    }
  }

  /// Removes the triangles that do not count from a verdict.
  HWY_NOINLINE void keep_counting(const Slot& slot, LeafBits& verdict) const {
    const LeafBlock& block = block_of(slot);
    const RayQuestion question{scene_, rays_, slot.number, counts_.decisions};
    const std::uint32_t lanes =
        counting_lanes(question, *resolved_, block, placement(slot, block).instance,
                       verdict.accept | verdict.examine, verdict.accept, verdict.back);
    verdict.accept &= lanes;
    verdict.examine &= lanes;
  }

  HWY_INLINE void take_closest(Slot& slot, const LeafBlock& block, const LeafVerdict& verdict) {
    for (std::uint32_t rest = verdict.accept; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(rest));
      const Candidate candidate{&block, lane, placement(slot, block).instance, 0};
      const Interval tau{verdict.low[lane], verdict.high[lane]};
      if (HWY_UNLIKELY(!slot.best.accept(candidate, tau))) settle_closest(slot, candidate, tau);
    }
    if (HWY_UNLIKELY(verdict.examine != 0)) examine_closest(slot, block, verdict.examine);

    // Siblings that are now too far are removed from the stack, so that popping needs no test.
    const float limit = slot.ray.box.limit(slot.best.bound());
    if (!(limit < slot.limit)) return;
    slot.limit = limit;
    drop_farther(slot);
  }

  /// Removes stack elements of the present tree that are beyond the limit.
  HWY_INLINE void drop_farther(Slot& slot) const {
    const float limit = slot.limit;
    std::uint32_t resolved = first(slot);
    for (std::uint32_t i = resolved; i < slot.waiting; ++i) {
      slot.ref[resolved] = slot.ref[i];
      slot.near[resolved] = slot.near[i];
      resolved += slot.near[i] <= limit ? 1 : 0;
    }
    slot.waiting = resolved;
  }

  HWY_NOINLINE void settle_closest(Slot& slot, const Candidate& candidate, Interval tau) {
    const RayQuestion question{scene_, rays_, slot.number, counts_.decisions};
    slot.best.settle(question, candidate, tau);
  }

  HWY_NOINLINE void examine_closest(Slot& slot, const LeafBlock& block, std::uint32_t examine) {
    const RayQuestion question{scene_, rays_, slot.number, counts_.decisions};
    for (; examine != 0; examine &= examine - 1) {
      slot.best.examine(question, {&block, static_cast<std::uint32_t>(std::countr_zero(examine)),
                                   placement(slot, block).instance});
    }
  }

  HWY_INLINE bool meets_any(Slot& slot, const LeafBlock& block, const LeafBits& verdict) {
    return verdict.accept != 0 || examine_any_of(slot, block, verdict.examine);
  }

  HWY_NOINLINE bool examine_any_of(Slot& slot, const LeafBlock& block, std::uint32_t examine) {
    const RayQuestion question{scene_, rays_, slot.number, counts_.decisions};
    for (; examine != 0; examine &= examine - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(examine));
      if (sightline::examine_any(question, {placement(slot, block).instance, block.triangle(lane)}))
        return true;
    }
    return false;
  }

  const SceneView& scene_;
  const SceneTree& tree_;
  const WideTree& root_;         ///< the top tree, or the tree of the only entry
  const std::byte* base_;        ///< start of the arena of root_
  const Placement* placements_;  ///< placements of the scene
  const RayBatch& rays_;
  std::span<const RayGroup> groups_;
  std::uint8_t* occluded_;
  const ResolvedFilter* resolved_;
  TraceCounts& counts_;
  GroupPreparation preparation_;
  Slot* free_[kInFlight];
  std::size_t free_count_ = 0;
  Verdict verdicts_[kInFlight];
  Slot slots_[kInFlight];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
