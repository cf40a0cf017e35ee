#pragma once
/// Traversal kernels: one body compiled per instruction set, chosen at run time.

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

/// What `all` counts and lists.
struct KernelLists {
  Crossings crossings;
  std::size_t hits_max;   ///< of each ray, in `hits`
  std::uint64_t* totals;  ///< how many triangles each ray meets: the slots of the batch
  HitBatch* hits;         ///< the first hits of every ray are appended, by (t, id); may be null
};

/// All of them answer the same bytes (law 1). Rays [begin, end) of a checked batch; slots of the
/// same numbers are overwritten. Errors: std::bad_alloc. Cost: closest and any allocate nothing but
/// up to 140 KB where rays are put in order.
struct Kernel {
  std::string_view name;  ///< "avx512", "avx2", "sse4", "baseline", "neon"
  void (*closest)(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                  HitBatch& hits, TraceCounts& counts);
  void (*any)(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
              std::uint8_t* occluded, TraceCounts& counts);
  /// How many triangles each ray meets, and which. Memory: all_hits.h.
  void (*all)(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
              const KernelLists& lists, TraceCounts& counts);
  // Closest, any and count among the triangles that count.
  void (*closest_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                           std::size_t end, const ResolvedFilter& resolved, HitBatch& hits,
                           TraceCounts& counts);
  void (*any_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                       std::size_t end, const ResolvedFilter& resolved, std::uint8_t* occluded,
                       TraceCounts& counts);
  void (*all_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                       std::size_t end, const ResolvedFilter& resolved, const KernelLists& lists,
                       TraceCounts& counts);
  /// The properties of the hits of the rays. Slots of misses are not written. out[i] belongs to ray
  /// i.
  void (*details)(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                  const HitBatch& hits, HitDetail* out, TraceCounts& counts);
  /// Rays against the boxes of a request, pairs [begin, end). Columns of `answers` that are empty
  /// are not written. Allocates nothing.
  void (*ray_boxes)(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                    std::size_t begin, std::size_t end, RayBoxAnswers& answers);
};

/// The kernels that this machine can run, best first; never empty.
std::vector<Kernel> supported_kernels();

}  // namespace sightline
