#pragma once
/// BoxOverlaps: finds all triangles or nodes of a scene that count for a closed box or another
/// shape (BoxRelation), exactly.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/watch.h"
#include "core/query/box_answers.h"
#include "core/query/box_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

/// Counts of the work, summed over calls.
struct OverlapCounts {
  std::uint64_t nodes = 0;      ///< wide nodes whose eight boxes were tested
  std::uint64_t triangles = 0;  ///< triangles that were decided
};

/// Answers one shape of a BoxBatch after the other. Call any() or list(), then check stopped(). Not
/// thread-safe; each thread has one. Precondition of any() and list(): the trees of the view that
/// the shape touches are built.
class BoxOverlaps {
 public:
  /// Retains the view. The scene and the deadline must outlive this object.
  BoxOverlaps(SceneView scene, const Deadline& deadline)
      : scene_(std::move(scene)),
        deadline_(deadline),
        node_seen_(scene_.description().nodes.size(), 0) {}

  /// True if any triangle counts for shape i.
  bool any(const BoxBatch& boxes, std::size_t i, BoxRelation relation = BoxRelation::kIntersecting);
  /// Returns how many triangles or nodes count for shape i. Also lists them, in triangles() or
  /// nodes(): those whose place (list_place) is at least `from`, ascending, up to `limit`. Throws
  /// std::bad_alloc.
  std::uint64_t list(const BoxBatch& boxes, std::size_t i, BoxTargets targets, std::size_t limit,
                     BoxRelation relation = BoxRelation::kIntersecting, std::uint64_t from = 0);

  /// The list of triangles of the last list(); empty if nodes were listed.
  const std::vector<TriangleId>& triangles() const { return triangles_; }
  /// The list of nodes of the last list(), as indices in SceneDescription::nodes.
  const std::vector<std::uint32_t>& nodes() const { return nodes_; }
  /// The place at which the last list would go on; 0 if it was complete, or nothing was to be
  /// listed.
  std::uint64_t next() const { return next_; }
  /// True if the deadline passed: the results are unusable.
  bool stopped() const { return stopped_; }
  const OverlapCounts& counts() const { return counts_; }

 private:
  /// The result of a callback for a found triangle.
  enum class Next {
    kOn,             ///< continue with the next triangle
    kNextPlacement,  ///< skip the rest of this instance; from now on left(instance) returns true
    kStop,
  };
  template <class Box, class Found, class Left>
  void walk(const Box& box, Found found, Left left);
  template <class Box, class Found, class Left>
  bool walk_placement(const Box& box, const Placement& placement, Found& found, Left& left);
  template <class Box, class Found, class Left>
  Next decide_leaf(const Box& box, const Placement& entered, const WideTree& tree,
                   std::uint32_t leaf, Found& found, Left& left);
  bool out_of_time();
  template <class Box>
  bool has_time_for(const Box& box);
  void keep_smallest(std::size_t limit);
  template <class Box>
  std::uint64_t list_triangles(const Box& box, std::size_t limit, std::uint64_t from);
  template <class Box>
  std::uint64_t list_nodes(const Box& box, std::size_t limit, std::uint64_t from);
  template <class Box>
  void leave_nodes_within(const Box& box);
  template <class Id>
  void cut(std::vector<Id>& ids, std::uint64_t resolved, std::size_t limit);

  const SceneView scene_;
  const Deadline& deadline_;
  std::vector<TriangleId> triangles_;
  std::vector<std::uint32_t> nodes_;
  std::vector<std::uint32_t> node_seen_;  ///< by node: the query that found the node last
  std::uint32_t query_ = 0;
  BoxRelation relation_ = BoxRelation::kIntersecting;
  std::uint64_t next_ = 0;
  DeadlineWatch watch_{deadline_, DeadlineWatch::kNodes};
  bool stopped_ = false;
  OverlapCounts counts_;
};

}  // namespace sightline
