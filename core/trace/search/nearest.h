#pragma once
/// NearestTriangles: the triangles of a scene that are nearest to a point, exactly.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/watch.h"
#include "core/geometry/point_triangle.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/scene/scene_view.h"
#include "core/trace/trace_counts.h"

namespace sightline {

struct TreePoint;

/// A triangle in world space and an interval that contains its distance from the point.
struct NearTriangle {
  DistanceRange range;
  TriangleId id;
  Triangle triangle;
};

/// Answers one point after the other: find(), check stopped(), write(). Which triangles are
/// nearest, and their order, is decided exactly: by distance, and at equal distance by id. Only
/// distances with overlapping intervals are compared exactly.
class NearestTriangles {
 public:
  /// `resolved`: the primitives that may be nearest, each with any of its sides; null: all. Retains
  /// the view; the scene, `*resolved` and `deadline` must outlive this object.
  NearestTriangles(SceneView scene, const ResolvedFilter* resolved, const Deadline& deadline)
      : scene_(std::move(scene)), resolved_(resolved), deadline_(deadline) {}

  /// Finds the triangles nearest to the point: at most `count`, at distances up to and including
  /// `max_distance`. Unbuilt trees are searched as empty. Preconditions: the point is finite,
  /// max_distance is not negative, count is not 0. Throws std::bad_alloc.
  void find(const Vec3d& point, double max_distance, std::size_t count);

  /// The result of find(), sorted by distance and id.
  const std::vector<NearTriangle>& found() const { return found_; }
  /// Writes the result to the slots [first, first + count) of `hits`, misses last; t is the
  /// distance, correctly rounded. Precondition: `hits` has these slots.
  void write(std::size_t first, HitBatch& hits) const;
  /// A triangle that is certainly farther than this cannot be in the result: max_distance, or less
  /// if `count` triangles were found.
  double reach() const {
    return found_.size() == count_ ? std::min(max_distance_, found_.back().range.high)
                                   : max_distance_;
  }
  /// True if the deadline passed: the result is unusable.
  bool stopped() const { return stopped_; }
  const TraceCounts& counts() const { return counts_; }

 private:
  void enter(const Placement& placement);
  void look_at_leaf(const Placement& entered, LeafBlocks blocks);
  void offer(NearTriangle near);
  bool comes_before(const NearTriangle& a, const NearTriangle& b);
  bool counts_at_all(TriangleId id) const;
  bool is_within(const NearTriangle& near);
  bool out_of_time();
  template <class Leaf>
  void walk_tree(const WideTree& tree, const TreePoint& point, Leaf leaf);

  const SceneView scene_;
  const ResolvedFilter* resolved_;
  const Deadline& deadline_;
  std::vector<NearTriangle> found_;
  Vec3d point_;
  double max_distance_ = 0;
  std::size_t count_ = 0;
  DeadlineWatch watch_{deadline_, DeadlineWatch::kNodes};
  bool stopped_ = false;
  TraceCounts counts_;
};

/// Properties of the point of the triangle that is nearest to `point`, every number correctly
/// rounded. front: the query point lies strictly on the side from which the corners run
/// counter-clockwise. Precondition: find() has found the triangle.
HitDetail detail_of_nearest(const Scene& scene, const Vec3d& point, TriangleId id);

}  // namespace sightline
