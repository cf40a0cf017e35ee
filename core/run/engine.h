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

/// The settings with which an engine is made.
struct EngineOptions {
  int threads = 0;  ///< 0: one for each processor
  /// empty: the fastest kernel that this machine can run; else one of Engine::kernels()
  std::string kernel;
  /// Set while short requests wait for the processor: then threads yield the processor between
  /// pieces of a batch. May be null. The flag must outlive the engine.
  const std::atomic<bool>* should_yield = nullptr;
};

struct FilteredRays;

/// Options of a query. The pointers are used only while the query runs.
struct RayOptions {
  /// Which triangles count (resolved_filter.h), resolved for the queried scene; null: all. A filter
  /// with masks requires RayBatch::mask.
  const ResolvedFilter* resolved = nullptr;
  QueryWork* work = nullptr;  ///< the cost of the query is added to it; may be null
  /// True: trees that a query needs are built first. False: closest, any, count and the queries
  /// that consist of them (inside, visibility, sky) fail with TREES_PENDING if any tree of the
  /// scene is unbuilt. Other queries ignore it and build.
  bool builds = true;
  /// Called before memory is allocated whose size depends on the scene rather than on the query;
  /// only inside() does that. Null: no limit.
  ReserveBytes reserve = {};
  /// True, for closest, any, count and all: hits on transparent texels of masked materials do not
  /// count (alpha_cutoff.h).
  bool alpha_cutoff = false;
  /// For closest, any, count and all: if not empty, each ray is in one group, whose filter it has
  /// instead of `resolved` (grouped_rays.h).
  std::span<const FilteredRays> groups = {};
};

/// Answers queries. main makes one engine with create() and passes it on. Each query is one call
/// that blocks until the answer is complete. All methods may be called from many threads at once,
/// and none stores a pointer to its arguments. The bytes of an answer do not depend on the number
/// of threads, the kernel, or the order of rays (docs/reference/contract.md); only the contact of
/// sweep() with `any` may. Preconditions: rays have passed check_rays. Errors of every query:
/// DEADLINE and CANCELLED, MEMORY_EXHAUSTED, TREES_PENDING (RayOptions::builds). After an error the
/// output must not be used.
class Engine {
 public:
  /// Makes an engine. Errors: ENGINE_KERNEL_UNKNOWN.
  static Result<std::unique_ptr<Engine>> create(const EngineOptions& options);
  /// Names of the kernels that this machine can run, widest vectors first.
  static std::vector<std::string> kernels();
  ~Engine();

  /// Finds the closest hit of every ray. `hits` is resized and overwritten: slot i answers ray i.
  Status closest(const Scene& scene, const RayBatch& rays, const Deadline& deadline, HitBatch& hits,
                 const RayOptions& options = {}) const;
  /// For each ray 1 if it meets a triangle that counts, else 0. `occluded` is resized and
  /// overwritten.
  Status any(const Scene& scene, const RayBatch& rays, const Deadline& deadline,
             Column<std::uint8_t>& occluded, const RayOptions& options = {}) const;
  /// For each ray the number of triangles that it meets; `crossings` says how often edges and
  /// corners count. `totals` is resized and overwritten.
  Status count(const Scene& scene, const RayBatch& rays, Crossings crossings,
               const Deadline& deadline, Column<std::uint64_t>& totals,
               const RayOptions& options = {}) const;
  /// For each ray the triangles that it meets, sorted by (exact t, id), up to question.each_max.
  /// `totals` has the number of all of them, so that a caller recognises a shortened list. `lists`
  /// and `totals` are resized and overwritten. Errors: TOO_MANY_HITS if the lists would have more
  /// than question.total_max hits in total.
  Status all(const Scene& scene, const RayBatch& rays, const HitListQuestion& question,
             const Deadline& deadline, HitLists& lists, Column<std::uint64_t>& totals,
             const RayOptions& options = {}) const;
  /// The cost of closest for each ray, traced alone in the trees that are built. It depends neither
  /// on the kernel nor on the other rays. Of the options only `resolved` matters. `costs` is resized
  /// and overwritten. Memory: a HitBatch for all rays.
  Status costs(const Scene& scene, const RayBatch& rays, const Deadline& deadline, RayCosts& costs,
               const RayOptions& options = {}) const;
  /// Position, normal and barycentrics of hits that closest or all reported. Slot i of `hits`
  /// belongs to rays[i], so after all() the caller repeats a ray for each of its hits. `out` is
  /// resized and overwritten; slots of misses have default values.
  Status details(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                 const Deadline& deadline, Column<HitDetail>& out) const;
  /// Computes HitDetail::normal alone. That costs less than details(): for neighbouring hits of one
  /// triangle it is computed once. `out` is resized and overwritten; slots of misses are zero.
  Status normals(const Scene& scene, const HitBatch& hits, const Deadline& deadline,
                 Column<Vec3d>& out) const;
  /// Sets HitDetail::on_edge in `details`, the result of details() for these arguments.
  Status mark_edges(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                    const Deadline& deadline, Column<HitDetail>& details) const;
  /// Interpolates vertex attributes of the file at hits. `details` is the result of details() for
  /// `hits`. Reads the attributes from the file's bytes in memory. Requested columns of `out` are
  /// resized and overwritten; the others do not change.
  Status attributes(const Scene& scene, const HitBatch& hits, const Column<HitDetail>& details,
                    const HitAttributeChoice& choice, const Deadline& deadline,
                    HitAttributes& out) const;

  // Queries about points. Precondition: points are finite. A filter selects whole primitives: all
  // triangles of a primitive count if options.resolved has any of its sides (core/run/nearest.cpp).

  /// For each point the triangles nearest to it: at most `count`, at distances up to and including
  /// max_distance, in scene units, sorted by exact distance, then by id. `hits` is overwritten:
  /// slots [i * count, (i + 1) * count) belong to point i, with misses last; t is the distance,
  /// correctly rounded. Preconditions: max_distance is not negative and not NaN, count is not 0.
  Status nearest(const Scene& scene, const Column<Vec3d>& points, double max_distance,
                 std::size_t count, const Deadline& deadline, HitBatch& hits,
                 const RayOptions& options = {}) const;
  /// The nearest point of each triangle that nearest() reported, every number correctly rounded.
  /// Slot i of `hits` belongs to points[i], so after nearest() the caller repeats each point
  /// `count` times. `out` is resized and overwritten; slots of misses have default values.
  /// HitDetail::front: the query point lies strictly on the side from which the corners run
  /// counter-clockwise.
  Status nearest_details(const Scene& scene, const Column<Vec3d>& points, const HitBatch& hits,
                         const Deadline& deadline, Column<HitDetail>& out) const;

  /// For each point, whether it lies inside of closed surfaces. Uses Crossings::kOnce, so edges and
  /// corners that a ray meets do no harm. `answers` is overwritten, except `distance`. Cost: for
  /// each point a test of the point itself, and three rays (kParity) or six (kWinding); the first
  /// query of a mesh counts its open edges.
  Status inside(const Scene& scene, const Column<Vec3d>& points, InsideMethod method,
                const Deadline& deadline, InsideAnswers& answers,
                const RayOptions& options = {}) const;
  /// Calls inside(), and for each point sets answers.distance: the distance to the nearest
  /// triangle, correctly rounded, negative inside, 0 on a triangle. If no triangle is within
  /// max_distance, it is +inf outside and -inf inside. Precondition: that of nearest() for
  /// max_distance.
  Status signed_distances(const Scene& scene, const Column<Vec3d>& points, InsideMethod method,
                          double max_distance, const Deadline& deadline, InsideAnswers& answers,
                          const RayOptions& options = {}) const;

  /// The most rays that visibility() and sky() trace at a time, to limit memory.
  static constexpr std::size_t kRaysAtOnce = 131072;
  /// For each pair 1 if no triangle blocks the line between its points, else 0 (PointPairs::ray).
  /// `visible` is resized and overwritten. `blockers` may be null. If not, slot i gets the first
  /// triangle that pair i meets, starting at its point `from`; t is the fraction of the way. Slots
  /// of visible pairs are misses. Precondition: the pairs have passed check_pairs.
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
  /// Finds the pairs of a triangle selected by `a` and a triangle selected by `b` that `question`
  /// asks for, with their distances; `answer` is overwritten. A filter selects whole primitives, as
  /// for points. A triangle in both selections has distance 0 to itself. The cost is added to
  /// `work` unless it is null; QueryWork::nodes then counts pairs of boxes. Errors: TOO_MANY_HITS
  /// for more than question.total_max pairs. Runs on the calling thread. Cost: n log n for a tree
  /// over each selection, then proportional to the number of close pairs.
  Status clearance(const Scene& scene, const ResolvedFilter& a, const ResolvedFilter& b,
                   const ClearanceQuestion& question, const Deadline& deadline,
                   ClearanceAnswer& answer, QueryWork* work = nullptr) const;

  // Sweeps. Precondition: they have passed check_sweeps. A filter selects whole primitives, as for
  // points.

  /// The first contact of each sweep: the least real t, and of contacts at equal t the smallest id.
  /// If `any`, it is some contact instead: whether there is one is certain, but which one is not
  /// specified. `hits` is resized and overwritten; t is correctly rounded.
  Status sweep(const Scene& scene, const SweepBatch& sweeps, bool any, const Deadline& deadline,
               HitBatch& hits, const RayOptions& options = {}) const;
  /// The position of each contact that sweep() reported, each coordinate correctly rounded; slot i
  /// of `hits` belongs to sweep i. `out` is resized and overwritten. Other members of HitDetail,
  /// and slots of misses, have default values.
  Status sweep_details(const Scene& scene, const SweepBatch& sweeps, const HitBatch& hits,
                       const Deadline& deadline, Column<HitDetail>& out) const;

  // Boxes and other shapes (BoxBatch). Precondition: they have passed check_boxes. There is no
  // filter: triangles of all instances that are not hidden are tested.

  /// Tests rays against boxes, without a scene: ray i with box i, or all pairs (slot = ray * number
  /// of boxes + box). `answers` is resized and overwritten. Preconditions: `boxes` has only
  /// axis-aligned and oriented boxes; for kEach, as many as rays.
  Status ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                   RayBoxDetail detail, const Deadline& deadline, RayBoxAnswers& answers) const;
  /// An estimate of how many triangles the boxes come near in total, for admission. It is all
  /// triangles for a region of planes; for another shape a part of them, by the two widest sides of
  /// its bounds within the scene's. A shape that meets the scene's bounds counts at least an eighth
  /// of the triangles or 2^19, whichever is less. It reads no triangle. Where a scene is denser than
  /// elsewhere, it is too low.
  static std::uint64_t expected_triangles(const Scene& scene, const BoxBatch& boxes);
  /// For each box 1 if any triangle counts by `relation`, else 0. `touched` is resized and
  /// overwritten.
  Status boxes_any(const Scene& scene, const BoxBatch& boxes, const Deadline& deadline,
                   Column<std::uint8_t>& touched,
                   BoxRelation relation = BoxRelation::kIntersecting) const;
  /// For each box the number of triangles or nodes that count by question.relation; question.from
  /// does not matter. `totals` is resized and overwritten.
  Status boxes_count(const Scene& scene, const BoxBatch& boxes, const BoxQuestion& question,
                     const Deadline& deadline, Column<std::uint64_t>& totals) const;
  /// For each box the triangles or nodes that count, sorted by id, beginning at the place
  /// question.from, up to limits.each. `totals` has the number of all that count, also before that
  /// place. `lists` and `totals` are resized and overwritten. Errors: TOO_MANY_HITS if all lists
  /// would have more than limits.total items in total.
  Status boxes_list(const Scene& scene, const BoxBatch& boxes, const BoxQuestion& question,
                    const ListLimits& limits, const Deadline& deadline, BoxLists& lists,
                    Column<std::uint64_t>& totals) const;

  /// The contacts of the triangles of `lists`, which boxes_list found for these boxes. `contacts` is
  /// resized and overwritten. Precondition: no shape with triangles is a convex region of planes.
  Status boxes_contacts(const Scene& scene, const BoxBatch& boxes, const BoxLists& lists,
                        const Deadline& deadline, BoxContacts& contacts) const;

  /// Name of the kernel in use, and number of threads.
  const std::string& kernel() const;
  int threads() const;

 private:
  struct State;
  explicit Engine(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace sightline
