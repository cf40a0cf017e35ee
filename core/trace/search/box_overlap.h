#pragma once
/// Boxes against a scene: every triangle of it that a closed box touches, exactly.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/deadline.h"
#include "core/query/box_answers.h"
#include "core/query/box_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

/// Counted per call, added to what is there.
struct OverlapCounts {
  std::uint64_t nodes = 0;      ///< wide nodes whose eight boxes were tested
  std::uint64_t triangles = 0;  ///< triangles decided
};

/// What one box touches, found in the order of the trees and sorted at the end.
class BoxOverlaps {
 public:
  /// The scene and the deadline outlive this object.
  BoxOverlaps(SceneView scene, const Deadline& deadline)
      : scene_(std::move(scene)),
        deadline_(deadline),
        node_seen_(scene_.description().nodes.size(), 0) {}

  /// Whether any triangle counts for box i.
  bool any(const BoxBatch& boxes, std::size_t i, BoxRelation relation = BoxRelation::kIntersecting);
  /// How many triangles or nodes count for box i; of those whose place (list_place) is not below
  /// `from` the `limit` first ones are then in triangles() or nodes(), ascending. Throws
  /// std::bad_alloc.
  std::uint64_t list(const BoxBatch& boxes, std::size_t i, BoxTargets targets, std::size_t limit,
                     BoxRelation relation = BoxRelation::kIntersecting, std::uint64_t from = 0);

  const std::vector<TriangleId>& triangles() const { return triangles_; }
  const std::vector<std::uint32_t>& nodes() const { return nodes_; }
  /// Where the last list would go on; 0 if nothing is left, or nothing was to be listed.
  std::uint64_t next() const { return next_; }
  /// The deadline passed in the middle: what was found is unusable.
  bool stopped() const { return stopped_; }
  const OverlapCounts& counts() const { return counts_; }

 private:
  /// What the finder of a triangle wants next.
  enum class Next {
    kOn,             ///< the next triangle
    kNextPlacement,  ///< nothing more of this placement: `left` says so from now on
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
  std::vector<std::uint32_t> node_seen_;  ///< the query in which a node was found last
  std::uint32_t query_ = 0;
  BoxRelation relation_ = BoxRelation::kIntersecting;
  std::uint64_t next_ = 0;
  std::uint64_t looks_ = 0;
  bool stopped_ = false;
  OverlapCounts counts_;
};

}  // namespace sightline
