// Traversal: traverses one ray at a time, for requests of one ray, for "all", and for scenes that
// the batch methods do not support. For each ray call prepare(), make a sink, and call run().

#if defined(SIGHTLINE_TRACE_SINGLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_SINGLE_INL_H_
#undef SIGHTLINE_TRACE_SINGLE_INL_H_
#else
#define SIGHTLINE_TRACE_SINGLE_INL_H_
#endif

#include <bit>
#include <limits>

#include "core/trace/decision.h"
#include "core/trace/kernel/all_hits.h"
#include "core/trace/kernel/enter-inl.h"
#include "core/trace/kernel/filter-inl.h"
#include "core/trace/kernel/kernel.h"
#include "core/trace/kernel/prepare-inl.h"
#include "core/trace/kernel/slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Elements of the stack: up to seven siblings at each level of two trees of at most about 130
/// levels each. Not a multiple of 4 KiB: a load whose address equals that of an earlier store but
/// for such a multiple waits for the store.
constexpr std::size_t kStack = 2048 + 16;
/// The deadline is checked once in so many steps (nodes or leaves); ordinary rays take fewer.
/// Reading the clock takes about as long as two steps.
constexpr std::uint32_t kStepsBetweenLooks = 64;

/// The stack of a traversal: references of nodes and leaves to visit, and their entry distances.
struct Stack {
  HWY_ALIGN std::uint32_t ref[kStack];
  HWY_ALIGN float near[kStack];
};

/// Sinks: they get the triangles of each visited leaf that the filter does not exclude. take()
/// returns true if the traversal may stop; bound() is an upper bound of the tau that still matters;
/// kWanted is the order of the visit. TakeClosest finds the closest hit.
struct TakeClosest {
  static constexpr Wanted kWanted = Wanted::kNearest;
  const RayQuestion& question;
  ClosestHit best;

  double bound() const { return best.bound(); }
  bool take(const LeafBlock& block, std::uint32_t instance, const LeafVerdict& verdict) {
    for (std::uint32_t rest = verdict.accept; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(rest));
      const Interval tau{verdict.low[lane], verdict.high[lane]};
      // Two candidates: the address of the first is not taken, so it stays in registers.
      if (!best.accept({&block, lane, instance}, tau))
        best.settle(question, {&block, lane, instance}, tau);
    }
    for (std::uint32_t rest = verdict.examine; rest != 0; rest &= rest - 1) {
      best.examine(question,
                   {&block, static_cast<std::uint32_t>(std::countr_zero(rest)), instance});
    }
    return false;
  }
};

/// The sink for "any": `found` says whether the ray meets a triangle.
struct TakeAny {
  static constexpr Wanted kWanted = Wanted::kAny;
  const RayQuestion& question;
  double tau_max;
  bool found = false;

  double bound() const { return tau_max; }
  bool take(const LeafBlock& block, std::uint32_t instance, const LeafVerdict& verdict) {
    found = verdict.accept != 0;
    for (std::uint32_t rest = verdict.examine; rest != 0 && !found; rest &= rest - 1) {
      found = examine_any(
          question, {instance, block.triangle(static_cast<std::size_t>(std::countr_zero(rest)))});
    }
    return found;
  }
};

/// The sink for "all" and "count": adds the triangles to `hits`.
struct TakeAll {
  static constexpr Wanted kWanted = Wanted::kAny;
  const RayQuestion& question;
  double tau_max;
  AllHits& hits;

  double bound() const { return tau_max; }
  bool take(const LeafBlock& block, std::uint32_t instance, const LeafVerdict& verdict) {
    for (std::uint32_t rest = verdict.accept; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
      hits.accept({instance, block.triangle(lane)}, {verdict.low[lane], verdict.high[lane]});
    }
    for (std::uint32_t rest = verdict.examine; rest != 0; rest &= rest - 1) {
      hits.examine({instance, block.triangle(static_cast<std::size_t>(std::countr_zero(rest)))});
    }
    return false;
  }
};

/// The traversal of one ray after the other through a tree or, if there are several entries,
/// through the top tree and the trees of the entries. The arguments of the constructor must outlive
/// it.
class Traversal {
 public:
  Traversal(const SceneView& scene, const RayBatch& rays, Stack& stack, TraceCounts& counts)
      : scene_(scene.tree()),
        rays_(rays),
        stack_(stack),
        counts_(counts),
        alone_(scene_.entries == 1 && scene_.placements[0].world_boxes),
        preparation_(scene_.bounds, alone_ ? scene_.trees[scene_.placements[0].tree]->scale_exponent
                                           : scene_.top.scale_exponent) {}

  /// Sets up ray `number` of the batch. Precondition: the scene has placements.
  HWY_INLINE void prepare(std::size_t number) {
    preparation_.prepare(rays_, number, ray_);
    if (!alone_) anchored_ = anchored(rays_[number], ray_, scene_.bounds);
  }
  /// Upper end of the interval of the ray's limit, for the sink. Precondition: prepare() was
  /// called.
  double tau_max() const { return ray_.tau_max; }

  /// Traverses the prepared ray until sink.take() returns true, or until the deadline
  /// (TraceCounts::stopped).
  template <class Sink>
  void run(Sink& sink) {
    if (counts_.stopped) return;
    if (alone_) {
      enter(scene_.placements[0], ray_.box, 0, sink);
      return;
    }
    if (scene_.entries == 1) {
      enter(scene_.placements[0], 0, sink);
      return;
    }
    walk(scene_.top, ray_.box, BoxRayLanes(ray_.box), 0, sink,
         [&](std::uint32_t ref, std::size_t base) {
           const LeafBlock& block = scene_.top.blocks(ref).front();
           for (std::uint32_t i = 0; i < block.lane_count(); ++i) {
             if (enter(scene_.placements[block.triangle(i)], base, sink)) return true;
           }
           return false;
         });
  }

 private:
  template <class Sink>
  bool enter(const Placement& placement, std::size_t base, Sink& sink) {
    const WideTree& tree = *scene_.trees[placement.tree];
    BoxRay box;
    enter_placement(anchored_, placement, tree, scene_.top, ray_.box, box);
    return enter(placement, box, base, sink);
  }

  /// Enters a placement of the scene; placements that share its tree follow it in
  /// SceneTree::placements.
  template <class Sink>
  bool enter(const Placement& placement, const BoxRay& box, std::size_t base, Sink& sink) {
    const WideTree& tree = *scene_.trees[placement.tree];
    ++counts_.placements;
    if (placement.identity) {
      return walk(
          tree, box, BoxRayLanes(box), base,
          sink, [&](std::uint32_t ref, std::size_t) HWY_ATTR __attribute__((always_inline)) {
            return visit<false>(tree.blocks(ref), placement, sink);
          });
    }
    return walk(
        tree, box, BoxRayLanes(box), base,
        sink, [&](std::uint32_t ref, std::size_t) HWY_ATTR __attribute__((always_inline)) {
          return visit<true>(tree.blocks(ref), placement, sink);
        });
  }

  /// Passes the triangles of a leaf that may be met to the sink. Returns true if it may stop. Not
  /// inlined: the filter needs all registers, and those of walk() would be moved to memory.
  template <bool kPlaced, class Sink>
  HWY_NOINLINE bool visit(LeafBlocks blocks, const Placement& placement, Sink& sink) {
    LeafVerdict verdict;
    for (const LeafBlock& block : blocks) {
      ++counts_.blocks;
      const Placement& own = (&placement)[block.placement()];
      filter_block<kPlaced, Pace::kLatency>(block, ray_.filter, own, sink.bound(), verdict);
      if ((verdict.accept | verdict.examine) == 0) continue;
      if (sink.take(block, own.instance, verdict)) return true;
    }
    return false;
  }

  /// Visits the leaves that the ray may meet, in the order that Sink wants, until leaf() returns
  /// true. `ray` has the numbers of `box`. The caller makes it, so that it stays in memory:
  /// registers would be saved at each call of leaf().
  template <class Sink, class Leaf>
  HWY_NOINLINE bool walk(const WideTree& tree, const BoxRay& box, const BoxRayLanes& ray,
                         std::size_t base, Sink& sink, Leaf leaf) {
    const NearRows<std::size_t> near_row{box.near_row[0], box.near_row[1], box.near_row[2]};
    const std::uint32_t octant = box.octant;
    std::size_t size = base;
    std::uint32_t ref = tree.root;
    double bound = sink.bound();
    auto limit = in_lanes(box.limit(bound));
    for (;;) {
      if (HWY_UNLIKELY(--steps_left_ == 0)) {
        steps_left_ = kStepsBetweenLooks;
        if (counts_.is_too_late()) return true;
      }
      if (ChildRef::is_leaf(ref)) {
        if (leaf(ref, size)) return true;
        if (bound != sink.bound()) {
          bound = sink.bound();
          limit = in_lanes(box.limit(bound));
        }
      } else {
        ++counts_.nodes;
        const WideNode& node = tree.node(ref);
        const BoxCrossings boxes = cross_boxes(node, ray, near_row, limit);
        ChildList list(node, boxes);
        const std::uint32_t met = list.bits();
        if (met != 0) {
          if ((met & (met - 1)) == 0) {
            // A single child needs no sorting.
            ref = node.child[std::countr_zero(met)];
          } else {
            ref = push_all_but_first<Sink::kWanted>(node, list, octant, size);
            // The child on top will most likely be popped next.
            fetch_node(tree.arena.at(ChildRef::granule(stack_.ref[size - 1])));
          }
          continue;
        }
      }
      do {
        if (size == base) return false;
        --size;
      } while (!(stack_.near[size] <= hn::GetLane(limit)));
      ref = stack_.ref[size];
    }
  }

  /// Pushes the children of `list`, at least two, onto the stack of `size` elements, but for the
  /// child to visit first. Returns that one: a single ray then does not wait for the stack.
  template <Wanted kWanted>
  HWY_INLINE std::uint32_t push_all_but_first(const WideNode& node, ChildList& list,
                                              std::uint32_t octant, std::size_t& size) {
    if constexpr (kWanted == Wanted::kNearest) list.sort(node, octant);
    const std::uint32_t met = list.bits();
    auto first = 31 - static_cast<std::uint32_t>(hwy::Num0BitsAboveMS1Bit_Nonzero32(met));
    list.store(met ^ 1u << first, stack_.ref + size, stack_.near + size);
    size += static_cast<std::size_t>(std::popcount(met)) - 1;
    if (kWanted == Wanted::kNearest) first = node.order[octant] >> (3 * first) & 7u;
    return node.child[first];
  }

  const SceneTree& scene_;
  const RayBatch& rays_;
  Stack& stack_;
  TraceCounts& counts_;
  std::uint32_t steps_left_ = kStepsBetweenLooks;  ///< until the deadline is checked
  bool alone_;  ///< the scene has one tree, in world units: no top tree, no mapping
  SinglePreparation preparation_;
  PreparedRay ray_;
  AnchoredRay anchored_;  ///< is mapped into trees; set only if !alone_
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
