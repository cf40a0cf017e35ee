#pragma once
/// Traversal kernels: one body compiled per instruction set, chosen at run time.

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/deadline.h"
#include "core/query/box_batch.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"
#include "core/scene/scene_view.h"
#include "core/trace/decision.h"

namespace sightline {

/// Counted per call, added to what is there; and how long the call may take.
struct TraceCounts {
  /// Polled at intervals by single rays and interleaved rays, so that no ray goes on for long after
  /// it. Null: no deadline.
  const Deadline* deadline = nullptr;
  bool stopped = false;  ///< it had passed: the answers of this call are unusable
  bool is_too_late() {
    stopped = stopped || (deadline != nullptr && deadline->passed());
    return stopped;
  }
  std::uint64_t nodes = 0;          ///< wide nodes whose eight boxes were tested
  std::uint64_t blocks = 0;         ///< leaf blocks of four triangles that were tested
  std::uint64_t placements = 0;     ///< placements entered
  std::uint64_t packet_rays = 0;    ///< rays that went in packets
  std::uint64_t packet_nodes = 0;   ///< nodes that packets opened
  std::uint64_t packet_boxes = 0;   ///< boxes that were tested for all rays of a packet at once
  std::uint64_t packet_leaves = 0;  ///< leaves that packets visited
  DecisionCounts decisions{};
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
  /// How many triangles each ray meets: slots of `totals`. If `hits` is not null the first
  /// `hits_max` of every ray are appended to it in order of (t, id). Memory: all_hits.h.
  void (*all)(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
              Crossings crossings, std::size_t hits_max, std::uint64_t* totals, HitBatch* hits,
              TraceCounts& counts);
  // Closest, any and count among the triangles that count.
  void (*closest_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                           std::size_t end, const KeptSides& kept, HitBatch& hits,
                           TraceCounts& counts);
  void (*any_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                       std::size_t end, const KeptSides& kept, std::uint8_t* occluded,
                       TraceCounts& counts);
  void (*all_filtered)(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                       std::size_t end, const KeptSides& kept, Crossings crossings,
                       std::size_t hits_max, std::uint64_t* totals, HitBatch* hits,
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
