#pragma once
/// Sweeps: the first contacts of spheres, capsules and boxes that are swept through a scene, exactly.

#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/watch.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/sweep_batch.h"
#include "core/scene/scene_view.h"
#include "core/trace/search/tree_sweep.h"
#include "core/trace/trace_counts.h"

namespace sightline {

/// Answers one sweep after the other: find(), check stopped(). The answer is the contact with the
/// least real t; at equal t the smallest id.
class Sweeps {
 public:
  /// `resolved`: the primitives that may be hit, each with any of its sides; null: all. Retains the
  /// view; the scene, `*resolved` and `deadline` must outlive this object.
  Sweeps(SceneView scene, const ResolvedFilter* resolved, const Deadline& deadline)
      : scene_(std::move(scene)), resolved_(resolved), deadline_(deadline) {}

  /// Writes the first contact of sweep i, or a miss, to slot i of `hits`. If `any`, writes some
  /// contact, not necessarily the first. Precondition: `hits` has a slot for each sweep, and the
  /// trees of the view that the sweep touches are built. Throws std::bad_alloc.
  void find(const SweepBatch& sweeps, std::size_t i, bool any, HitBatch& hits);

  /// True if the deadline passed: the result is unusable.
  bool stopped() const { return stopped_; }
  const TraceCounts& counts() const { return counts_; }

 private:
  template <class Shape>
  struct Search;
  template <class Shape>
  void run(Search<Shape>& search);
  template <class Shape>
  void enter(const Placement& placement, Search<Shape>& search);
  template <class Shape>
  void look_at_leaf(const Placement& entered, LeafBlocks blocks, Search<Shape>& search);
  template <class Shape, class Leaf>
  void walk_tree(const WideTree& tree, const TreeSweep& sweep, Search<Shape>& search, Leaf leaf);
  bool counts_at_all(TriangleId id) const;
  bool out_of_time();

  const SceneView scene_;
  const ResolvedFilter* resolved_;
  const Deadline& deadline_;
  DeadlineWatch watch_{deadline_, DeadlineWatch::kNodes};
  bool stopped_ = false;
  TraceCounts counts_;
};

/// Position and normal of the first contact of sweep i with the triangle (see BoxContact and
/// CapsuleContact); a normal that there is not is NaN. Precondition: find() has found the triangle.
/// Throws std::bad_alloc.
HitDetail detail_of_contact(const Scene& scene, const SweepBatch& sweeps, std::size_t i,
                            TriangleId id);

}  // namespace sightline
