#pragma once
/// Engine: answers queries about a scene on a fixed number of threads.

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

/// How an engine is made.
struct EngineOptions {
  int threads = 0;  ///< 0: one for each processor
  /// empty: the fastest kernel that this machine can run; else one of Engine::kernels()
  std::string kernel;
  /// Set while short requests wait for the processor: then threads yield between pieces of a batch.
  /// May be null; must outlive the engine.
  const std::atomic<bool>* should_yield = nullptr;
};

/// Options of a query.
struct RayOptions {
  /// which triangles count (resolved_filter.h); null: all
  const ResolvedFilter* resolved = nullptr;
  QueryWork* work = nullptr;  ///< if not null, the cost of the query is added
  /// True: trees that a query needs are built. False: closest, any and count fail with
  /// TREES_PENDING if one is not built.
  bool builds = true;
  /// Called before memory is allocated whose size depends on the scene rather than on the query.
  ReserveBytes reserve = {};
};

/// Answers queries. main makes one engine and passes it on. All methods may be called from many
/// threads at once, and none stores a pointer to its arguments. The bytes of an answer do not
/// depend on the number of threads, the kernel, or the order of rays (docs/reference/contract.md).
/// Precondition: rays have passed check_rays. Errors: DEADLINE and CANCELLED (the output must then
/// not be used), MEMORY_EXHAUSTED, TREES_PENDING (RayOptions::builds), ENGINE_KERNEL_UNKNOWN from
/// create.
class Engine {
 public:
  static Result<std::unique_ptr<Engine>> create(const EngineOptions& options);
  /// Names of the kernels that this machine can run, widest vectors first.
  static std::vector<std::string> kernels();
  ~Engine();

  /// The nearest triangle of every ray. `hits` is resized and overwritten.
  Status closest(const Scene& scene, const RayBatch& rays, const Deadline& deadline, HitBatch& hits,
                 const RayOptions& options = {}) const;
  /// For each ray 1 if it meets a triangle, else 0. `occluded` is resized and overwritten.
  Status any(const Scene& scene, const RayBatch& rays, const Deadline& deadline,
             Column<std::uint8_t>& occluded, const RayOptions& options = {}) const;
  /// For each ray the number of triangles that it meets. `totals` is resized and overwritten.
  Status count(const Scene& scene, const RayBatch& rays, Crossings crossings,
               const Deadline& deadline, Column<std::uint64_t>& totals,
               const RayOptions& options = {}) const;
  /// For each ray the triangles that it meets, sorted by (exact t, id), up to question.each_max.
  /// `totals` has the number of all of them, so that a cut list can be recognised. `lists` and
  /// `totals` are resized and overwritten. Errors: TOO_MANY_HITS if the lists would have
  /// more than question.total_max hits.
  Status all(const Scene& scene, const RayBatch& rays, const HitListQuestion& question,
             const Deadline& deadline, HitLists& lists, Column<std::uint64_t>& totals,
             const RayOptions& options = {}) const;
  /// Position, normal and barycentrics of hits that closest or all reported; rays[i] belongs to
  /// slot i of `hits`. `out` is resized and overwritten; slots of misses have default values.
  Status details(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                 const Deadline& deadline, Column<HitDetail>& out) const;
  /// Computes HitDetail::normal alone, which costs less: neighbouring hits of one triangle are
  /// computed once. `out` is resized and overwritten; slots of misses are zero.
  Status normals(const Scene& scene, const HitBatch& hits, const Deadline& deadline,
                 Column<Vec3d>& out) const;
  /// Sets HitDetail::on_edge in the result of `details` for the same arguments.
  Status mark_edges(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                    const Deadline& deadline, Column<HitDetail>& details) const;
  /// Interpolates vertex attributes of the file at hits. `details` is the result of details() for
  /// `hits`. Reads the attributes from the file's bytes in memory. `out` is resized and
  /// overwritten.
  Status attributes(const Scene& scene, const HitBatch& hits, const Column<HitDetail>& details,
                    const HitAttributeChoice& choice, const Deadline& deadline,
                    HitAttributes& out) const;

  // Queries about points. Precondition: points are finite. A filter selects whole primitives:
  // options.resolved must have all sides of a primitive or none (core/run/nearest.cpp).

  /// For each point the triangles nearest to it: at most `count`, within max_distance (closed),
  /// sorted by exact distance, then by id. `hits` is overwritten: slots [i * count, (i + 1) *
  /// count) belong to point i, with misses last; t is the distance, correctly rounded.
  /// Preconditions: max_distance is not negative, count is not 0.
  Status nearest(const Scene& scene, const Column<Vec3d>& points, double max_distance,
                 std::size_t count, const Deadline& deadline, HitBatch& hits,
                 const RayOptions& options = {}) const;
  /// The nearest point of each triangle that nearest() reported, every number correctly rounded:
  /// slot i of `hits` belongs to points[i]. Slots of misses have default values. HitDetail::front:
  /// the query point lies on the side from which the corners run counter-clockwise.
  Status nearest_details(const Scene& scene, const Column<Vec3d>& points, const HitBatch& hits,
                         const Deadline& deadline, Column<HitDetail>& out) const;

  /// For each point, whether it lies inside of closed surfaces. Uses Crossings::kOnce, so edges and
  /// corners on the way of a ray do no harm. `answers` is overwritten. Cost: for each point a test
  /// of the point itself, and three rays (kParity) or six (kWinding).
  Status inside(const Scene& scene, const Column<Vec3d>& points, InsideMethod method,
                const Deadline& deadline, InsideAnswers& answers,
                const RayOptions& options = {}) const;
  /// inside(), and for each point the distance to the nearest triangle, correctly rounded: negative
  /// inside, 0 on a triangle, +inf beyond max_distance.
  Status signed_distances(const Scene& scene, const Column<Vec3d>& points, InsideMethod method,
                          double max_distance, const Deadline& deadline, InsideAnswers& answers,
                          const RayOptions& options = {}) const;

  /// visibility() and sky() trace at most so many rays at a time, to limit memory.
  static constexpr std::size_t kRaysAtOnce = 131072;
  /// For each pair 1 if no triangle is between its points, else 0. `visible` is resized and
  /// overwritten. If `blockers` is not null, it gets the first triangle that is met from `from`,
  /// with t as the fraction of the way; slots of visible pairs are misses. Precondition: the pairs
  /// have passed check_pairs.
  Status visibility(const Scene& scene, const PointPairs& pairs, const Deadline& deadline,
                    Column<std::uint8_t>& visible, HitBatch* blockers,
                    const RayOptions& options = {}) const;
  /// For each point the number of its samples.count directions that meet nothing between range.tmin
  /// and range.tmax: any() for the rays of generate_rays. `unblocked` is resized and overwritten.
  /// Preconditions: there are as many normals as points, and samples.count is not 0. Errors: those
  /// of generate_rays. Memory: the rays of one point, or kRaysAtOnce rays if that is more.
  Status sky(const Scene& scene, const Hemisphere& samples, const RayRange& range,
             const Deadline& deadline, Column<std::uint64_t>& unblocked,
             const RayOptions& options = {}) const;
  /// Pairs of a triangle selected by `a` and a triangle selected by `b`, with their distances; a
  /// selection has all sides of a primitive or none. A triangle in both selections has distance 0
  /// to itself. The cost is added to `work` if not null; its nodes are pairs of boxes. Errors:
  /// TOO_MANY_HITS for more than question.total_max pairs. Runs on the calling thread. Cost: n log
  /// n for a tree over each selection, then proportional to the number of close pairs.
  Status clearance(const Scene& scene, const ResolvedFilter& a, const ResolvedFilter& b,
                   const ClearanceQuestion& question, const Deadline& deadline,
                   ClearanceAnswer& answer, QueryWork* work = nullptr) const;

  // Sweeps. Precondition: they have passed check_sweeps. A filter selects whole primitives:
  // options.resolved must have all sides of a primitive or none (core/run/sweeps.cpp).

  /// The first contact of each sweep: the least real t, and of contacts at equal t the smallest id.
  /// If `any`, some contact instead: whether there is one does not depend on the number of threads,
  /// but which one may. `hits` is resized and overwritten; t is correctly rounded.
  Status sweep(const Scene& scene, const SweepBatch& sweeps, bool any, const Deadline& deadline,
               HitBatch& hits, const RayOptions& options = {}) const;
  /// The position of each contact that sweep() reported, each coordinate correctly rounded. Other
  /// members of HitDetail, and slots of misses, have default values.
  Status sweep_details(const Scene& scene, const SweepBatch& sweeps, const HitBatch& hits,
                       const Deadline& deadline, Column<HitDetail>& out) const;

  // Boxes. Precondition: they have passed check_boxes.

  /// Tests rays against boxes, without a scene: ray i with box i, or all pairs (slot = ray * boxes
  /// + box). `answers` is resized and overwritten. Precondition for kEach: there are as many boxes
  /// as rays.
  Status ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                   RayBoxDetail detail, const Deadline& deadline, RayBoxAnswers& answers) const;
  /// For each box 1 if any triangle counts, else 0. `touched` is resized and overwritten.
  Status boxes_any(const Scene& scene, const BoxBatch& boxes, const Deadline& deadline,
                   Column<std::uint8_t>& touched,
                   BoxRelation relation = BoxRelation::kIntersecting) const;
  /// For each box the number of triangles or nodes that count. `totals` is resized and overwritten.
  Status boxes_count(const Scene& scene, const BoxBatch& boxes, const BoxQuestion& question,
                     const Deadline& deadline, Column<std::uint64_t>& totals) const;
  /// For each box the triangles or nodes that count, sorted by id, from question.from on, up to
  /// limits.each. `totals` has the number of all of them. `lists` and `totals` are resized and
  /// overwritten. Errors: TOO_MANY_HITS if all lists would have more than limits.total entries.
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
