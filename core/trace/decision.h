#pragma once
/// Where filters end and exact tests begin. Stores the best triangle so far by intervals, and calls
/// the exact predicate where an interval leaves the order open.

#include <limits>

#include "core/geometry/exact_hit.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/scene/scene_view.h"
#include "core/trace/ray_setup.h"
#include "core/trace/trace_counts.h"

namespace sightline {

/// What a decision needs to ask the exact predicate, for one ray of a batch.
struct RayQuestion {
  const SceneView& scene;
  const RayBatch& rays;
  std::size_t number;
  DecisionCounts& counts;

  Ray ray() const { return rays[number]; }
  /// Contains the tau of an exact t.
  Interval tau_of(const ExactT& t) const {
    return anchor_ray(ray(), scene.tree().bounds).tau_of(t.approximate());
  }
};

/// A triangle where a kernel found it.
struct Candidate {
  const LeafBlock* block = nullptr;
  std::uint32_t lane = 0;
  std::uint32_t instance = kNone;
  CornerSet edge = 0;  ///< where the ray is known to meet an edge or a corner of it: met_edge

  TriangleId id() const { return {instance, block->triangle(lane)}; }
};

/// The closest hit of one ray while its candidates arrive in any order. The answer does not depend
/// on that order: every pair of candidates is compared by disjoint intervals or exactly.
struct ClosestHit {
  Interval tau{kNever, kNever};
  Candidate candidate;

  static constexpr double kNever = std::numeric_limits<double>::infinity();
  /// No triangle whose tau is certainly larger can win.
  explicit ClosestHit(double tau_max) : tau{kNever, tau_max} {}
  ClosestHit() = default;
  double bound() const { return tau.high; }
  bool found() const { return candidate.instance != kNone; }

  /// Takes a triangle that is certainly met, at a tau inside the interval and certainly within the
  /// limits, if the intervals tell. False if they do not: then `settle` does.
  bool accept(const Candidate& other, Interval other_tau) {
    if (other_tau.high < tau.low) {
      tau = other_tau;
      candidate = other;
      return true;
    }
    return other_tau.low > tau.high;
  }
  /// Decides between the best and a certain hit whose intervals overlap.
  void settle(const RayQuestion& question, const Candidate& other, Interval other_tau);
  /// Decides exactly whether a triangle is met and beats the best.
  void examine(const RayQuestion& question, Candidate other);
};

/// The sides of a triangle whose hits count, of ResolvedFilter.
inline std::uint8_t counting_sides(const Scene& scene, const ResolvedFilter& resolved,
                                   TriangleId id) {
  const std::size_t first = resolved.first[id.instance];
  const std::size_t end = id.instance + 1 < resolved.first.size() ? resolved.first[id.instance + 1]
                                                                  : resolved.sides.size();
  return resolved.sides[end - first == 1 ? first : first + scene.primitive_of(id)];
}
/// Those of `lanes` of a block whose hits count, on the side that the ray meets.
std::uint32_t counting_lanes(const RayQuestion& question, const ResolvedFilter& resolved,
                             const LeafBlock& block, std::uint32_t instance, std::uint32_t lanes);

/// Whether the exact predicate finds the triangle within the ray's limits, and where.
bool exact_hit_of(const RayQuestion& question, TriangleId id, ExactT& t);
bool examine_any(const RayQuestion& question, TriangleId id);

/// The exact t of a triangle that the ray meets, rounded once.
double exact_t(const Scene& scene, const Ray& ray, TriangleId id);

/// Position, normal and barycentrics where the ray meets the triangle, computed exactly and rounded
/// once. Default values if it does not meet it.
HitDetail hit_detail(const Scene& scene, const Ray& ray, TriangleId id);

/// Whether the ray meets the triangle on an edge or a corner, exactly. `detail` is what hit_detail
/// says of it, within the bounds that HitDetail promises.
bool hit_on_edge(const Scene& scene, const Ray& ray, TriangleId id, const HitDetail& detail);

}  // namespace sightline

// Tests: tests/unit/trace/all_hits_test.cpp
