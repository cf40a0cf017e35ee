#pragma once
/// Kinds of pairs of nodes: how the triangles of two nodes that a clearance question selects lie to
/// each other.

#include <map>
#include <optional>
#include <vector>

#include "core/base/deadline.h"
#include "core/query/clearance.h"
#include "core/run/engine.h"
#include "core/trace/search/convex_body.h"
#include "core/trace/search/triangle_group.h"

namespace sightline {

/// Classifies pairs of nodes. All arguments must outlive this object.
class NodeClashes {
 public:
  /// One selection of the question: the filter that it resolved to, and its triangles.
  struct Side {
    const ResolvedFilter& resolved;
    const TriangleGroup& group;
  };
  NodeClashes(const Engine& engine, const Scene& scene, const Side& a, const Side& b,
              const ClearanceQuestion& question, const Deadline& deadline);

  /// Completes the answer of a search for ClearancePairs::kNodes that has all pairs within the
  /// distance. Sets `kind` and `depth` of each, and counts kinds. Adds pairs of which one lies
  /// inside of the other, farther from its surface. Errors: DEADLINE, CANCELLED, MEMORY_EXHAUSTED,
  /// TOO_MANY_HITS for more than question.total_max pairs. Throws std::bad_alloc. Cost: each pair
  /// of nodes is compared by its boxes; of pairs whose boxes lie inside of each other, each corner
  /// is tested with three rays.
  Status complete(ClearanceAnswer& answer);

 private:
  /// The triangles of a node that a selection has.
  struct Body {
    std::vector<Triangle> triangles;
    Box3d box;
    std::optional<std::optional<ConvexBody>> convex;  ///< empty until it is needed
  };
  using Bodies = std::map<std::uint32_t, Body>;

  static Bodies bodies_of(const Scene& scene, const TriangleGroup& group);
  ResolvedFilter only(const Side& side, std::uint32_t node) const;
  /// True if each corner of `body` is inside or on the surface of a node, and one is inside.
  Result<bool> is_inside(const Body& body, const Side& side, std::uint32_t node) const;
  Status classify(ClearancePair& pair, std::uint32_t a, std::uint32_t b);
  Status find_kind(ClearancePair& pair, const Body& of_a, std::uint32_t a, const Body& of_b,
                   std::uint32_t b) const;
  Status add_inside(std::uint32_t a, std::uint32_t b, ClearanceAnswer& answer);
  static const std::optional<ConvexBody>& convex(Body& body);
  Bodies& of_b() { return is_alike_ ? bodies_a_ : bodies_b_; }

  const Engine& engine_;
  const Scene& scene_;
  const Side a_, b_;
  const ClearanceQuestion& question_;
  const Deadline& deadline_;
  const bool is_alike_;
  Bodies bodies_a_, bodies_b_;
};

}  // namespace sightline

// Tests: tests/unit/run/clash_test.cpp
