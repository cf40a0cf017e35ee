#pragma once
/// Some triangles of a scene under a tree of their own, for questions between two selections: the
/// trees of a scene hold what is not asked for as well.

#include <cstdint>
#include <vector>

#include "core/base/deadline.h"
#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"
#include "core/query/hit_filter.h"
#include "core/scene/scene.h"

namespace sightline {

class TriangleGroup {
 public:
  struct Member {
    TriangleId id;
    Triangle triangle;
  };
  struct Node {
    Box3d box;                           ///< exactly around its members
    TriangleId least;                    ///< of their ids
    std::uint32_t first = 0, count = 0;  ///< its members
    std::uint32_t child = 0;             ///< the first of two; 0: a leaf
  };

  /// The triangles of the primitives selected by `resolved`, except triangles without area. Must not be
  /// used if the deadline passed. Throws std::bad_alloc. Cost: n log n.
  TriangleGroup(const Scene& scene, const ResolvedFilter& resolved, const Deadline& deadline);

  bool empty() const { return members_.empty(); }
  std::uint32_t size() const { return static_cast<std::uint32_t>(members_.size()); }
  /// The root is the first; there is none if the group is empty.
  const Node& node(std::uint32_t i) const { return nodes_[i]; }
  const Member& member(std::uint32_t i) const { return members_[i]; }

 private:
  void split(std::uint32_t node);

  std::vector<Member> members_;
  std::vector<Node> nodes_;
};

}  // namespace sightline

// Tests: tests/unit/trace/clearance_test.cpp
