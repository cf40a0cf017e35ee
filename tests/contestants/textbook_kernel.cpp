#include "tests/contestants/textbook_kernel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/trace/kernel/targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/contestants/textbook_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "tests/contestants/node_slabs-inl.h"
#include "tests/contestants/triangle_tests-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::contestants {
namespace HWY_NAMESPACE {

template <class Test>
class TextbookInterleaved {
 public:
  TextbookInterleaved(const Scene& scene, const RayBatch& rays, HitBatch& hits)
      : tree_(*scene.tree()->trees[scene.tree()->placements[0].tree]),
        instance_(scene.tree()->placements[0].instance),
        rays_(rays),
        hits_(hits) {}

  void run(std::size_t begin, std::size_t end) {
    next_ = begin;
    end_ = end;
    Queues a, b;
    Queues* now = &a;
    Queues* then = &b;
    for (std::size_t i = 0; i < kFlying; ++i) free_[i] = &slots_[i];
    free_count_ = kFlying;
    for (;;) {
      while (next_ != end_ && free_count_ > 0) start(*now);
      if (now->size[kNode] + now->size[kLeaf] + now->size[kDone] == 0) return;
      for (std::uint32_t i = 0; i < now->size[kNode]; ++i) {
        Slot& slot = *now->slot[kNode][i];
        const std::uint32_t waiting = slot.waiting;
        const auto found = static_cast<std::uint32_t>(push_met_children(
            tree_.node(slot.next), slot.box, slot.limit, slot.ref + waiting, slot.near + waiting));
        slot.waiting = waiting + found - 1;
        proceed(slot, slot.ref[waiting + found - 1], *then);
      }
      for (std::uint32_t i = 0; i < now->size[kLeaf]; ++i) {
        Slot& slot = *now->slot[kLeaf][i];
        visit_leaf(slot);
        const std::uint32_t popped = slot.ref[slot.waiting - 1];
        --slot.waiting;
        proceed(slot, popped, *then);
      }
      for (std::uint32_t i = 0; i < now->size[kDone]; ++i) {
        finish(*now->slot[kDone][i]);
        free_[free_count_++] = now->slot[kDone][i];
      }
      now->size[kNode] = now->size[kLeaf] = now->size[kDone] = 0;
      std::swap(now, then);
    }
  }

 private:
  using Real = typename Test::Real;
  static constexpr std::size_t kFlying = 32;

  struct alignas(64) Slot {
    SlabRay box;
    typename Test::State state;
    Real tmin = 0, best = 0;
    std::uint32_t triangle = kNone;
    float limit = 0;
    std::size_t number = 0;
    std::uint32_t next = 0, waiting = 0;
    std::uint32_t ref[256];
    float near[256];
  };

  /// On the bottom of every stack; neither a leaf nor a granule that a tree has.
  static constexpr std::uint32_t kFinished = 0x40000000u;

  enum Class : std::uint32_t { kNode, kLeaf, kDone };
  struct Queues {
    std::uint32_t size[3] = {0, 0, 0};
    Slot* slot[3][kFlying];
  };

  HWY_INLINE void start(Queues& queues) {
    Slot& slot = *free_[--free_count_];
    const Ray ray = rays_[next_];
    slot.number = next_++;
    slot.box.set(ray);
    slot.state = Test::prepare(ray);
    slot.tmin = static_cast<Real>(ray.tmin);
    slot.best = static_cast<Real>(ray.tmax);
    slot.triangle = kNone;
    slot.limit = limit_of(slot.best);
    slot.ref[0] = kFinished;
    slot.near[0] = -std::numeric_limits<float>::infinity();
    slot.waiting = 1;
    proceed(slot, tree_.root, queues);
  }

  /// A float32 number that is surely not below t.
  static float limit_of(Real t) { return static_cast<float>(t) * (1 + 0x1p-20f); }

  HWY_INLINE void proceed(Slot& slot, std::uint32_t next, Queues& queues) const {
    slot.next = next;
    const std::byte* target = tree_.arena.at(ChildRef::granule(next));
    for (std::size_t line = 0; line < sizeof(WideNode); line += kNodeAlign) {
      hwy::Prefetch(target + line);
    }
    const std::uint32_t which = next >> 31 | ((next >> 30) == 1 ? 2u : 0u);
    queues.slot[which][queues.size[which]++] = &slot;
  }

  HWY_INLINE void visit_leaf(Slot& slot) {
    bool improved = false;
    for (const LeafBlock& block : tree_.blocks(slot.next)) {
      Real t[kLanes];
      std::uint32_t met = Test::meet(block, slot.state, t) & ((1u << block.lane_count()) - 1u);
      for (; met != 0; met &= met - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(met));
        const std::uint32_t id = block.triangle(lane);
        if (!(t[lane] >= slot.tmin && t[lane] <= slot.best)) continue;
        if (t[lane] == slot.best && slot.triangle < id) continue;
        slot.best = t[lane];
        slot.triangle = id;
        improved = true;
      }
    }
    if (!improved) return;
    slot.limit = limit_of(slot.best);
    std::uint32_t kept = 1;
    for (std::uint32_t i = 1; i < slot.waiting; ++i) {
      slot.ref[kept] = slot.ref[i];
      slot.near[kept] = slot.near[i];
      kept += slot.near[i] <= slot.limit ? 1 : 0;
    }
    slot.waiting = kept;
  }

  void finish(const Slot& slot) {
    const bool hit = slot.triangle != kNone;
    hits_.t[slot.number] =
        hit ? static_cast<double>(slot.best) : std::numeric_limits<double>::infinity();
    hits_.instance[slot.number] = hit ? instance_ : kNone;
    hits_.triangle[slot.number] = slot.triangle;
  }

  const WideTree& tree_;
  std::uint32_t instance_;
  const RayBatch& rays_;
  HitBatch& hits_;
  std::size_t next_ = 0, end_ = 0;
  Slot* free_[kFlying];
  std::size_t free_count_ = 0;
  Slot slots_[kFlying];
};

template <class Test>
void closest(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
             HitBatch& hits) {
  TextbookInterleaved<Test>(scene, rays, hits).run(begin, end);
}

void moeller_trumbore_float32(const Scene& scene, const RayBatch& rays, std::size_t begin,
                              std::size_t end, HitBatch& hits) {
  closest<MoellerTrumbore<float>>(scene, rays, begin, end, hits);
}
void moeller_trumbore_float64(const Scene& scene, const RayBatch& rays, std::size_t begin,
                              std::size_t end, HitBatch& hits) {
  closest<MoellerTrumbore<double>>(scene, rays, begin, end, hits);
}
void woop_float32(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                  HitBatch& hits) {
  closest<WoopWatertight>(scene, rays, begin, end, hits);
}
void pluecker_float32(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                      HitBatch& hits) {
  closest<Pluecker<float>>(scene, rays, begin, end, hits);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::contestants
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::contestants {

namespace {

HWY_EXPORT(moeller_trumbore_float32);
HWY_EXPORT(moeller_trumbore_float64);
HWY_EXPORT(woop_float32);
HWY_EXPORT(pluecker_float32);

}  // namespace

std::span<const TextbookKernel> textbook_kernels() {
  static const std::array<TextbookKernel, 4> kernels{
      {{"moeller_trumbore_float32", true,
        [](const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
           HitBatch& hits) {
          HWY_DYNAMIC_DISPATCH(moeller_trumbore_float32)(scene, rays, begin, end, hits);
        }},
       {"moeller_trumbore_float64", false,
        [](const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
           HitBatch& hits) {
          HWY_DYNAMIC_DISPATCH(moeller_trumbore_float64)(scene, rays, begin, end, hits);
        }},
       {"woop_float32", true,
        [](const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
           HitBatch& hits) {
          HWY_DYNAMIC_DISPATCH(woop_float32)
          (scene, rays, begin, end, hits);
        }},
       {"pluecker_float32", true,
        [](const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
           HitBatch& hits) {
          HWY_DYNAMIC_DISPATCH(pluecker_float32)(scene, rays, begin, end, hits);
        }}}};
  return kernels;
}

bool can_trace(const Scene& scene) {
  const auto held = scene.tree();
  const SceneTree& tree = *held;
  const WideTree* only =
      tree.placements.size() == 1 ? tree.trees[tree.placements[0].tree].get() : nullptr;
  // Seven siblings wait on each level of a slot's stack.
  return only != nullptr && tree.placements[0].identity && only->scale_exponent == 0 &&
         only->depth <= (256 - 8) / 7;
}

}  // namespace sightline::contestants
#endif
