#pragma once
/// Where filters end and truth begins: keeps the best triangle so far by intervals, and asks the
/// exact predicate for whatever an interval leaves open.

#include <memory>
#include <vector>

#include "core/geometry/exact_hit.h"
#include "core/query/hit_batch.h"
#include "core/scene/scene.h"
#include "core/trace/ray_setup.h"

namespace sightline {

/// How often a stage was needed, for tests, benchmarks and metrics.
struct DecisionCounts {
  std::uint64_t exact_hits = 0;      ///< triangles decided by the exact predicate
  std::uint64_t exact_compares = 0;  ///< pairs of t compared exactly
};

/// The closest hit of one ray while its candidates arrive in any order. The answer does not depend
/// on that order: every pair of candidates is compared by disjoint intervals or exactly.
class ClosestDecision {
 public:
  ClosestDecision(const Scene& scene, const Ray& ray, const AnchoredRay& anchored,
                  DecisionCounts& counts)
      : scene_(scene),
        ray_(ray),
        anchored_(anchored),
        counts_(counts),
        bound_(anchored.tau_max.high) {}

  /// A triangle that is certainly met, at a tau inside the interval and certainly within the
  /// limits.
  void accept(TriangleId id, Interval tau);
  /// A triangle that may be met.
  void examine(TriangleId id);

  /// No triangle whose tau is certainly larger can win.
  double bound() const { return bound_; }
  bool found() const { return id_.instance != kNone; }
  TriangleId id() const { return id_; }
  /// The exact t of the winner. Precondition: found().
  const ExactT& exact();

 private:
  void challenge(TriangleId id, Interval tau, const ExactT* exact);

  const Scene& scene_;
  const Ray& ray_;
  const AnchoredRay& anchored_;
  DecisionCounts& counts_;
  TriangleId id_;
  Interval tau_;
  double bound_;
  bool exact_known_ = false;
  ExactT exact_;
};

/// Every triangle that one ray meets, for "all" and "count".
class AllDecision {
 public:
  AllDecision(const Scene& scene, const Ray& ray, const AnchoredRay& anchored, Crossings crossings,
              DecisionCounts& counts)
      : scene_(scene), ray_(ray), anchored_(anchored), crossings_(crossings), counts_(counts) {}

  void accept(TriangleId id, Interval tau) { entries_.push_back({id, tau, nullptr}); }
  void examine(TriangleId id);

  double bound() const { return anchored_.tau_max.high; }
  std::size_t size() const { return entries_.size(); }
  /// Appends the hits sorted by (exact t, id), at most `limit` of them. Throws std::bad_alloc.
  void append_sorted(std::size_t limit, HitBatch& hits);

 private:
  struct Entry {
    TriangleId id;
    Interval tau;
    std::unique_ptr<ExactT> exact;
  };
  const ExactT& exact_of(Entry& entry);

  const Scene& scene_;
  const Ray& ray_;
  const AnchoredRay& anchored_;
  Crossings crossings_;
  DecisionCounts& counts_;
  std::vector<Entry> entries_;
};

/// Whether the exact predicate finds the triangle within the ray's limits.
bool examine_any(const Scene& scene, const Ray& ray, TriangleId id, DecisionCounts& counts);

/// Position, normal and barycentrics where the ray meets the triangle, computed exactly and rounded
/// once. Default values if it does not meet it.
HitDetail hit_detail(const Scene& scene, const Ray& ray, TriangleId id);

}  // namespace sightline
