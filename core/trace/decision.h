#pragma once
/// Decisions that filters leave open, and the exact answers about one ray and one triangle.
/// ClosestHit stores the best triangle so far as an interval of tau (ray_setup.h), and calls the
/// exact predicate if intervals do not decide.

#include <limits>

#include "core/geometry/exact_hit.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/scene/scene_view.h"
#include "core/trace/ray_setup.h"
#include "core/trace/trace_counts.h"

namespace sightline {

/// A ray of a batch, with what the exact predicate needs to decide about it. Made for one decision;
/// the referenced objects must outlive it. Decisions are added to `counts`.
struct RayQuestion {
  const SceneView& scene;
  const RayBatch& rays;
  std::size_t number;  ///< index of the ray in `rays`
  DecisionCounts& counts;

  Ray ray() const { return rays[number]; }
  /// An interval that contains tau for an exact t (ray_setup.h defines tau).
  Interval tau_of(const ExactT& t) const {
    return anchor_ray(ray(), scene.tree().bounds).tau_of(t.approximate());
  }
};

/// A triangle that a kernel found, by its lane in a leaf block. The block belongs to a tree of the
/// view (SceneView) of the query.
struct Candidate {
  const LeafBlock* block = nullptr;
  std::uint32_t lane = 0;
  std::uint32_t instance = kNone;  ///< kNone: no triangle
  /// corner or edge in which the ray is known to meet the triangle (exact_hit); 0: not known
  CornerSet edge = 0;

  TriangleId id() const { return {instance, block->triangle(lane)}; }
};

/// The closest hit of one ray. Construct it with the ray's limit; pass each triangle that the
/// filter does not exclude to accept() or examine(). Triangles may arrive in any order, and the
/// result does not depend on the order: two are compared by disjoint intervals or exactly.
struct ClosestHit {
  /// contains the tau of `candidate`; without a hit, high is the limit
  Interval tau{kNever, kNever};
  Candidate candidate;  ///< the best triangle so far

  static constexpr double kNever = std::numeric_limits<double>::infinity();
  /// Starts without a hit. `tau_max` is the upper end of the interval of the ray's limit: a
  /// triangle whose tau is certainly larger cannot win.
  explicit ClosestHit(double tau_max) : tau{kNever, tau_max} {}
  ClosestHit() = default;
  /// Triangles whose tau is certainly above this cannot win.
  double bound() const { return tau.high; }
  /// True if there is a hit.
  bool found() const { return candidate.instance != kNone; }

  /// Compares with a triangle that is certainly met within the limits, at a tau inside of
  /// `other_tau`. Returns true if the intervals decide, and false if not; the caller must then call
  /// settle().
  bool accept(const Candidate& other, Interval other_tau) {
    if (other_tau.high < tau.low) {
      tau = other_tau;
      candidate = other;
      return true;
    }
    return other_tau.low > tau.high;
  }
  /// Decides exactly between the best hit and a triangle that is certainly met, if their intervals
  /// overlap. Precondition: accept() returned false.
  void settle(const RayQuestion& question, const Candidate& other, Interval other_tau);
  /// Decides exactly whether a triangle that may be met is met within the limits, and whether it
  /// beats the best hit.
  void examine(const RayQuestion& question, Candidate other);
};

/// Returns those of `lanes` (bit i: lane i of the block) whose triangles count for the ray, given
/// the side that the ray meets and its mask. `instance` is that of the block's placement. The ray
/// certainly meets the triangles `certain`, of which it meets the backs `back`; the exact sign
/// decides the side of others.
std::uint32_t counting_lanes(const RayQuestion& question, const ResolvedFilter& resolved,
                             const LeafBlock& block, std::uint32_t instance, std::uint32_t lanes,
                             std::uint32_t certain, std::uint32_t back);

/// True if the exact predicate finds the triangle within the ray's limits; sets `t`, which is else
/// unspecified.
bool exact_hit_of(const RayQuestion& question, TriangleId id, ExactT& t);
/// True if the exact predicate finds the triangle within the ray's limits.
bool examine_any(const RayQuestion& question, TriangleId id);

/// The exact t of a triangle that the ray meets, rounded once. Precondition: the ray meets it.
double exact_t(const Scene& scene, const Ray& ray, TriangleId id);
/// exact_t for a triangle in world space.
double exact_t(const Ray& ray, const Triangle& triangle);

/// Position, normal and barycentrics of the point where the ray meets the triangle, computed
/// exactly and rounded once. Default values if the ray does not meet it.
HitDetail hit_detail(const Scene& scene, const Ray& ray, TriangleId id);

/// True if the ray meets the triangle exactly on an edge or a corner; false for a miss. `detail` is
/// the result of hit_detail for these arguments, or of a kernel within the bounds of HitDetail.
bool hit_on_edge(const Scene& scene, const Ray& ray, TriangleId id, const HitDetail& detail);

}  // namespace sightline

// Tests: tests/unit/trace/all_hits_test.cpp
