#pragma once
/// Runs batches of checked rays on the threads that it was given.

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/query/box_answers.h"
#include "core/query/box_batch.h"
#include "core/query/clearance.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/inside_answers.h"
#include "core/query/point_pairs.h"
#include "core/query/query_work.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"
#include "core/query/ray_generators.h"
#include "core/scene/scene.h"

namespace sightline {

struct SweepBatch;

struct EngineOptions {
  int threads = 0;     ///< 0: as many as the machine has
  std::string kernel;  ///< empty: the best that this machine can run; else one of Engine::kernels()
  /// While it is set somebody has short work to do: between pieces of a batch threads ask whether
  /// others want the processor. May be null; outlives the engine.
  const std::atomic<bool>* should_yield = nullptr;
};

/// How a query is run.
struct RayOptions {
  const ResolvedFilter* resolved = nullptr;  ///< what counts (resolved_filter.h); null: everything
  QueryWork* work = nullptr;                 ///< what it cost is added, if not null
  /// else closest, any and count fail with TREES_PENDING where trees are unbuilt
  bool builds = true;
  /// Called before memory is taken that does not grow with the query, but with the scene.
  ReserveBytes reserve = {};
};

/// Answers queries. main makes one and passes it on. All methods may be called from many threads at
/// once. No method stores a pointer to its arguments. The bytes of an answer do not depend on the
/// number of threads, the kernel or the order of rays (docs/reference/contract.md). Rays must have
/// passed check_rays. Errors: DEADLINE and CANCELLED (the output must then not be used),
/// MEMORY_EXHAUSTED, TREES_PENDING (RayOptions::builds), ENGINE_KERNEL_UNKNOWN from create.
class Engine {
 public:
  static Result<std::unique_ptr<Engine>> create(const EngineOptions& options);
  /// Names of the kernels that this machine can run, best first.
  static std::vector<std::string> kernels();
  ~Engine();

  /// The nearest triangle of every ray. `hits` is resized and overwritten.
  Status closest(const Scene& scene, const RayBatch& rays, const Deadline& deadline, HitBatch& hits,
                 const RayOptions& options = {}) const;
  /// Whether each ray meets anything: 1 or 0. `occluded` is resized and overwritten.
  Status any(const Scene& scene, const RayBatch& rays, const Deadline& deadline,
             Column<std::uint8_t>& occluded, const RayOptions& options = {}) const;
  /// How many triangles each ray meets. `totals` is resized and overwritten.
  Status count(const Scene& scene, const RayBatch& rays, Crossings crossings,
               const Deadline& deadline, Column<std::uint64_t>& totals,
               const RayOptions& options = {}) const;
  /// Every triangle that each ray meets, sorted by (exact t, id); of each ray the first
  /// question.each_max. `totals` counts all of them, so that a cut is visible. Both are resized and
  /// overwritten. Errors: TOO_MANY_HITS if all lists would have more than question.total_max hits.
  Status all(const Scene& scene, const RayBatch& rays, const HitListQuestion& question,
             const Deadline& deadline, HitLists& lists, Column<std::uint64_t>& totals,
             const RayOptions& options = {}) const;
  /// Position, normal and barycentrics of hits that closest (or all) reported; slots of misses are
  /// left default. `rays[i]` belongs to `hits` slot i.
  Status details(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                 const Deadline& deadline, Column<HitDetail>& out) const;
  /// Fills HitDetail::on_edge of what `details` has filled. The same preconditions.
  Status mark_edges(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                    const Deadline& deadline, Column<HitDetail>& details) const;
  /// What the file says of the vertices of hits, with the weights of their details, of which there
  /// are as many. Reads the file where it lies. `out` is resized and overwritten.
  Status attributes(const Scene& scene, const HitBatch& hits, const Column<HitDetail>& details,
                    const HitAttributeChoice& choice, const Deadline& deadline,
                    HitAttributes& out) const;

  // Points are finite; see core/run/nearest.cpp. The filter selects whole primitives: in
  // options.resolved the sides of a primitive are all or none.

  /// The triangles nearest to each point, at most `count` of those within max_distance (closed),
  /// which triangles and in which order exactly: by distance, at the same distance by id. `hits` is
  /// overwritten: slots [i * count, (i + 1) * count) are point i's, misses last; t is the distance,
  /// correctly rounded. Preconditions: max_distance is not negative, count is not 0.
  Status nearest(const Scene& scene, const Column<Vec3d>& points, double max_distance,
                 std::size_t count, const Deadline& deadline, HitBatch& hits,
                 const RayOptions& options = {}) const;
  /// The nearest point of each of these triangles, every number correctly rounded: slot i of `hits`
  /// belongs to points[i]. Slots of misses are left default. HitDetail::front: the point lies on
  /// the counter-clockwise side.
  Status nearest_details(const Scene& scene, const Column<Vec3d>& points, const HitBatch& hits,
                         const Deadline& deadline, Column<HitDetail>& out) const;

  /// Which points lie inside. Crossings are counted once (Crossings::kOnce), so that edges and
  /// corners on the way do no harm. `answers` is overwritten. Cost: a ray that is a point and three
  /// rays for each point, six for kWinding.
  Status inside(const Scene& scene, const Column<Vec3d>& points, InsideMethod method,
                const Deadline& deadline, InsideAnswers& answers,
                const RayOptions& options = {}) const;
  /// `inside` and distances from the nearest triangle, negative inside, correctly rounded; 0 on it,
  /// +inf beyond max_distance.
  Status signed_distances(const Scene& scene, const Column<Vec3d>& points, InsideMethod method,
                          double max_distance, const Deadline& deadline, InsideAnswers& answers,
                          const RayOptions& options = {}) const;

  /// Visibility and sky make so many rays at a time, however many they need in total.
  static constexpr std::size_t kRaysAtOnce = 131072;
  /// Whether nothing of the scene is between the points of each pair: 1 or 0. `visible` is resized
  /// and overwritten. If `blockers` is not null it gets what is met first from `from`, t being the
  /// part of the way; of visible pairs a miss. Precondition: the pairs have passed check_pairs.
  Status visibility(const Scene& scene, const PointPairs& pairs, const Deadline& deadline,
                    Column<std::uint8_t>& visible, HitBatch* blockers,
                    const RayOptions& options = {}) const;
  /// How many of the samples.count directions of each point meet nothing between range.tmin and
  /// range.tmax: `any` for the rays of generate_rays. `unblocked` is resized and overwritten.
  /// Precondition: there are as many normals as points, and samples.count is not 0. Errors: those of
  /// generate_rays. Memory: one point's rays, or kRaysAtOnce.
  Status sky(const Scene& scene, const Hemisphere& samples, const RayRange& range,
             const Deadline& deadline, Column<std::uint64_t>& unblocked,
             const RayOptions& options = {}) const;
  /// The pairs of a triangle selected by `a` and a triangle selected by `b` (sides are all or none).
  /// A triangle in both has distance 0 to itself. What it cost is added to `work`, if not null;
  /// nodes are pairs of boxes. Errors: TOO_MANY_HITS for more than question.total_max pairs. Runs on
  /// the thread that calls. Cost: n log n for a tree over each selection, then proportional to the
  /// pairs that are close.
  Status clearance(const Scene& scene, const ResolvedFilter& a, const ResolvedFilter& b,
                   const ClearanceQuestion& question, const Deadline& deadline,
                   ClearanceAnswer& answer, QueryWork* work = nullptr) const;

  // Sweeps must have passed check_sweeps; see core/run/sweeps.cpp. The filter selects whole
  // primitives: in options.resolved the sides of a primitive are all or none.

  /// The first contact of each sweep: the least real t, and at equal t the smallest id. With `any`
  /// it is some contact; only its existence does not depend on the number of threads. `hits` is
  /// resized and overwritten; t is correctly rounded.
  Status sweep(const Scene& scene, const SweepBatch& sweeps, bool any, const Deadline& deadline,
               HitBatch& hits, const RayOptions& options = {}) const;
  /// The positions of first contacts, each coordinate correctly rounded; nothing else is filled in.
  /// Slots of misses are left default.
  Status sweep_details(const Scene& scene, const SweepBatch& sweeps, const HitBatch& hits,
                       const Deadline& deadline, Column<HitDetail>& out) const;

  // Boxes must have passed check_boxes. The same laws; see core/run/boxes.cpp.

  /// Rays against boxes, no scene: of the ray and the box of each slot, or of all pairs (slot = ray
  /// * boxes + box). `answers` is resized and overwritten. Precondition for kEach: as many boxes as
  /// rays.
  Status ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                   RayBoxDetail detail, const Deadline& deadline, RayBoxAnswers& answers) const;
  /// Whether any triangle counts for each box: 1 or 0. `touched` is resized and overwritten.
  Status boxes_any(const Scene& scene, const BoxBatch& boxes, const Deadline& deadline,
                   Column<std::uint8_t>& touched,
                   BoxRelation relation = BoxRelation::kIntersecting) const;
  /// How many triangles or nodes count for each box. `totals` is resized and overwritten.
  Status boxes_count(const Scene& scene, const BoxBatch& boxes, const BoxQuestion& question,
                     const Deadline& deadline, Column<std::uint64_t>& totals) const;
  /// The triangles or nodes that each box touches, sorted by id; of each box the first
  /// limits.each from its cursor on. `totals` counts all of them. Both are resized and overwritten.
  /// Errors: TOO_MANY_HITS if all lists would have more than limits.total entries.
  Status boxes_list(const Scene& scene, const BoxBatch& boxes, const BoxQuestion& question,
                    const ListLimits& limits, const Deadline& deadline, BoxLists& lists,
                    Column<std::uint64_t>& totals) const;

  const std::string& kernel() const;
  int threads() const;

 private:
  struct State;
  explicit Engine(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace sightline
