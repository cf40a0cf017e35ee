#pragma once
/// Kernel: the traversal of batches of rays, compiled for each instruction set and chosen at run
/// time. Engine splits a batch into slices and calls a kernel for each.

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/query/box_batch.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"
#include "core/scene/scene_view.h"
#include "core/trace/trace_counts.h"

namespace sightline {

/// The arguments and results of Kernel::all, which must outlive the call.
struct KernelLists {
  Crossings crossings;    ///< how often edges and corners count
  std::size_t hits_max;   ///< number of hits of each ray to append to `hits`
  std::uint64_t* totals;  ///< totals[i]: number of triangles that ray i meets; not null
  /// The first hits of each ray are appended, sorted by (exact t, id); null: not requested.
  HitBatch* hits;
};

/// The functions of one instruction set. All kernels give the same bytes (law 1 of
/// ARCHITECTURE.md). Each function processes the rays, hits or pairs [begin, end) of a checked
/// batch and overwrites the slots with these indices, which must exist. Several threads may call it
/// for disjoint ranges, each with its own `counts`. Costs are added to `counts`. Unbuilt trees are
/// traversed as empty. Errors: std::bad_alloc; if `counts.stopped` is set, the answers are
/// unusable. Memory: `closest` and `any` allocate nothing, or up to 140 KB if they bin rays.
struct Kernel {
  std::string_view name;  ///< "avx512", "avx2", "sse4", "baseline", "neon"
  /// The closest hit of each ray.
  void (*closest)(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                  HitBatch& hits, TraceCounts& counts);
  /// occluded[i] is 1 if ray i meets a triangle, else 0.
  void (*any)(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
              std::uint8_t* occluded, TraceCounts& counts);
  /// Counts, and lists, all triangles that each ray meets. Memory: all_hits.h.
  void (*all)(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
              const KernelLists& lists, TraceCounts& counts);
  // The three functions above, restricted to the triangles that count in `resolved`.
  void (*closest_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                           std::size_t end, const ResolvedFilter& resolved, HitBatch& hits,
                           TraceCounts& counts);
  void (*any_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                       std::size_t end, const ResolvedFilter& resolved, std::uint8_t* occluded,
                       TraceCounts& counts);
  void (*all_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                       std::size_t end, const ResolvedFilter& resolved, const KernelLists& lists,
                       TraceCounts& counts);
  /// The properties of the hits of each ray: slot i of `hits` and out[i] belong to ray i. Slots of
  /// misses are not written; HitDetail::on_edge is not set.
  void (*details)(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                  const HitBatch& hits, HitDetail* out, TraceCounts& counts);
  /// The unit normals of the triangles of hits [begin, end), correctly rounded. Slots of misses are
  /// not written. Allocates only where exact arithmetic decides.
  void (*normals)(const Scene& scene, std::size_t begin, std::size_t end, const HitBatch& hits,
                  Vec3d* out);
  /// Rays against the axis-aligned and oriented boxes of a request, for pairs [begin, end). Empty
  /// columns of `answers` are not written. Allocates nothing.
  void (*ray_boxes)(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                    std::size_t begin, std::size_t end, RayBoxAnswers& answers);
};

/// The kernels that this machine can run, fastest first; never empty.
std::vector<Kernel> supported_kernels();

}  // namespace sightline
