// Compiled once per instruction set by Highway; the scalar stages (ray_setup, decision) are shared.

#include "core/trace/kernel/kernel.h"

#include <limits>
#include <optional>

#include "core/trace/kernel/targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/kernel/kernel.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.
#include <hwy/highway.h>

#include "core/trace/kernel/batch_scheduler-inl.h"
#include "core/trace/kernel/detail-inl.h"
#include "core/trace/kernel/filtered-inl.h"
#include "core/trace/kernel/normal-inl.h"
#include "core/trace/kernel/single-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

void set_misses(HitBatch& hits, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    hits.t[i] = std::numeric_limits<double>::infinity();
    hits.instance[i] = hits.triangle[i] = kNone;
  }
}

/// Answers a batch by the batch scheduler; `resolved` may be null. False if it cannot take the
/// batch.
bool closest_together(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                      std::size_t end, const ResolvedFilter* resolved, TRounding& rounding,
                      TraceCounts& counts) {
  if (!can_use_packets(scene, end - begin)) return false;
  with_layout(scene, [&]<Layout kLayout>() {
    BatchScheduler<false, kLayout>(scene, rays, nullptr, resolved, counts)
        .run(begin, end, rounding);
  });
  rounding.flush();
  return true;
}
bool any_together(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                  const ResolvedFilter* resolved, std::uint8_t* occluded, TraceCounts& counts) {
  if (!can_use_packets(scene, end - begin)) return false;
  NoRounding none;
  with_layout(scene, [&]<Layout kLayout>() {
    BatchScheduler<true, kLayout>(scene, rays, occluded, resolved, counts).run(begin, end, none);
  });
  return true;
}

/// The closest hit of a single ray, without what only batches need. Precondition: the scene has
/// placements.
void closest_of_one(const SceneView& scene, const RayBatch& rays, std::size_t ray, HitBatch& hits,
                    TraceCounts& counts) {
  Stack stack;
  Traversal traversal(scene, rays, stack, counts);
  traversal.prepare(ray);
  const RayQuestion question{scene, rays, ray, counts.decisions};
  TakeClosest sink{question, ClosestHit(traversal.tau_max())};
  traversal.run(sink);
  if (!sink.best.found()) return set_misses(hits, ray, ray + 1);
  write_hit(scene, rays, ray, sink.best.candidate, hits, counts.decisions);
}

void trace_closest(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                   HitBatch& hits, TraceCounts& counts) {
  const bool is_empty = scene.tree().placements.empty();
  if (end - begin == 1 && !is_empty) return closest_of_one(scene, rays, begin, hits, counts);
  set_misses(hits, begin, end);
  if (is_empty) return;
  TRounding rounding(scene, rays, hits, counts.decisions);
  if (closest_together(scene, rays, begin, end, nullptr, rounding, counts)) return;
  Stack stack;
  Traversal traversal(scene, rays, stack, counts);
  for (std::size_t i = begin; i < end; ++i) {
    traversal.prepare(i);
    const RayQuestion question{scene, rays, i, counts.decisions};
    TakeClosest sink{question, ClosestHit(traversal.tau_max())};
    traversal.run(sink);
    if (sink.best.found()) rounding.add(i, sink.best.candidate);
  }
  rounding.flush();
}

void trace_any(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
               std::uint8_t* occluded, TraceCounts& counts) {
  for (std::size_t i = begin; i < end; ++i) occluded[i] = 0;
  if (scene.tree().placements.empty()) return;
  if (any_together(scene, rays, begin, end, nullptr, occluded, counts)) return;
  Stack stack;
  Traversal traversal(scene, rays, stack, counts);
  for (std::size_t i = begin; i < end; ++i) {
    traversal.prepare(i);
    const RayQuestion question{scene, rays, i, counts.decisions};
    TakeAny sink{question, traversal.tau_max()};
    traversal.run(sink);
    occluded[i] = sink.found ? 1 : 0;
  }
}

void trace_all(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
               const KernelLists& lists, TraceCounts& counts) {
  for (std::size_t i = begin; i < end; ++i) lists.totals[i] = 0;
  if (scene.tree().placements.empty()) return;
  const std::size_t limit = lists.hits == nullptr ? 0 : lists.hits_max;
  Stack stack;
  Traversal traversal(scene, rays, stack, counts);
  for (std::size_t i = begin; i < end; ++i) {
    traversal.prepare(i);
    const RayQuestion question{scene, rays, i, counts.decisions};
    AllHits all(question, lists.crossings, limit, counts);
    TakeAll sink{question, traversal.tau_max(), all};
    traversal.run(sink);
    lists.totals[i] = all.total();
    if (lists.hits != nullptr) all.append_sorted(*lists.hits);
  }
}

void trace_closest_filtered(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                            std::size_t end, const ResolvedFilter& resolved, HitBatch& hits,
                            TraceCounts& counts) {
  set_misses(hits, begin, end);
  if (scene.tree().placements.empty()) return;
  TRounding rounding(scene, rays, hits, counts.decisions);
  if (closest_together(scene, rays, begin, end, &resolved, rounding, counts)) return;
  trace_filtered(
      scene, rays, begin, end, resolved, counts,
      [](const RayQuestion& question, double tau_max) {
        return TakeClosest{question, ClosestHit(tau_max)};
      },
      [&](std::size_t i, const TakeClosest& sink) {
        if (sink.best.found()) rounding.add(i, sink.best.candidate);
      });
  rounding.flush();
}

void trace_any_filtered(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                        std::size_t end, const ResolvedFilter& resolved, std::uint8_t* occluded,
                        TraceCounts& counts) {
  for (std::size_t i = begin; i < end; ++i) occluded[i] = 0;
  if (scene.tree().placements.empty()) return;
  if (any_together(scene, rays, begin, end, &resolved, occluded, counts)) return;
  trace_filtered(
      scene, rays, begin, end, resolved, counts,
      [](const RayQuestion& question, double tau_max) {
        return TakeAny{question, tau_max};
      },
      [&](std::size_t i, const TakeAny& sink) { occluded[i] = sink.found ? 1 : 0; });
}

void trace_all_filtered(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                        std::size_t end, const ResolvedFilter& resolved, const KernelLists& lists,
                        TraceCounts& counts) {
  for (std::size_t i = begin; i < end; ++i) lists.totals[i] = 0;
  if (scene.tree().placements.empty()) return;
  const std::size_t limit = lists.hits == nullptr ? 0 : lists.hits_max;
  std::optional<AllHits> all;
  trace_filtered(
      scene, rays, begin, end, resolved, counts,
      [&](const RayQuestion& question, double tau_max) {
        return TakeAll{question, tau_max, all.emplace(question, lists.crossings, limit, counts)};
      },
      [&](std::size_t i, const TakeAll&) {
        lists.totals[i] = all->total();
        if (lists.hits != nullptr) all->append_sorted(*lists.hits);
      });
}

void trace_details(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                   const HitBatch& hits, HitDetail* out, TraceCounts& counts) {
  Details details(scene, rays, hits, out, counts);
  for (std::size_t i = begin; i < end; ++i) {
    if (hits.hit(i)) details.add(i);
  }
  details.flush();
}

void trace_normals(const Scene& scene, std::size_t begin, std::size_t end, const HitBatch& hits,
                   Vec3d* out) {
  Normals normals(scene, hits, out);
  for (std::size_t i = begin; i < end; ++i) {
    if (hits.hit(i)) normals.add(i);
  }
  normals.flush();
}

// core/trace/ray_boxes/ray_boxes.cpp
void answer_ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                      std::size_t begin, std::size_t end, RayBoxAnswers& answers);

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline {

std::vector<Kernel> supported_kernels() {
  std::vector<Kernel> kernels;
  const std::int64_t can = hwy::SupportedTargets();
  [[maybe_unused]] const auto add = [&](std::int64_t target, const Kernel& kernel) {
    if ((can & target) != 0) kernels.push_back(kernel);
  };
  // Named one by one, best first, so that a test or a flag can force each of them.
#define SIGHTLINE_KERNEL(name, target) \
  {name,                               \
   target::trace_closest,              \
   target::trace_any,                  \
   target::trace_all,                  \
   target::trace_closest_filtered,     \
   target::trace_any_filtered,         \
   target::trace_all_filtered,         \
   target::trace_details,              \
   target::trace_normals,              \
   target::answer_ray_boxes}
#if HWY_TARGETS & HWY_AVX3
  add(HWY_AVX3, SIGHTLINE_KERNEL("avx512", N_AVX3));
#endif
#if HWY_TARGETS & HWY_AVX2
  add(HWY_AVX2, SIGHTLINE_KERNEL("avx2", N_AVX2));
#endif
#if HWY_TARGETS & HWY_SSE4
  add(HWY_SSE4, SIGHTLINE_KERNEL("sse4", N_SSE4));
#endif
#if HWY_TARGETS & HWY_NEON
  add(HWY_NEON, SIGHTLINE_KERNEL("neon", N_NEON));
#endif
  if (kernels.empty() || HWY_ARCH_X86 != 0) {
    kernels.push_back(SIGHTLINE_KERNEL("baseline", HWY_NAMESPACE));
  }
#undef SIGHTLINE_KERNEL
  return kernels;
}

}  // namespace sightline
#endif
