#pragma once
/// Answers of box queries as columns.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/query/hit_batch.h"

namespace sightline {

/// The items that a box query counts and lists.
enum class BoxTargets {
  kTriangles,
  kNodes,  ///< nodes of the file, one of whose instances has a triangle that touches the box
};

/// Which triangles count.
enum class BoxRelation {
  kIntersecting,  ///< those that have a point in the closed box
  /// Items that lie wholly in the box. A node counts if it has triangles and all of them do;
  /// triangles without area are ignored.
  kContained,
};

/// The options of a box query.
struct BoxQuestion {
  BoxTargets targets;
  BoxRelation relation;
  /// For each box where its list begins (list_place); or nothing: at the begin.
  Column<std::uint64_t> from;

  // NOLINTNEXTLINE(*-explicit-*): most questions are just that
  BoxQuestion(BoxTargets of = BoxTargets::kTriangles,
              BoxRelation which = BoxRelation::kIntersecting)
      : targets(of), relation(which) {}
  std::uint64_t from_of(std::size_t i) const { return from.empty() ? 0 : from[i]; }
};

/// How much is listed.
struct ListLimits {
  std::size_t each = 0;   ///< the first entries of each list
  std::size_t total = 0;  ///< of all lists in total: more are an error
};

/// The place of a triangle or a node in the order of a list. Where a list goes on, it begins with
/// the least place that is not below a given one.
inline std::uint64_t list_place(const TriangleId& id) {
  return std::uint64_t{id.instance} << 32 | id.triangle;
}
inline std::uint64_t list_place(std::uint32_t node) { return node; }

/// The items that box i touches: entries first[i] .. first[i+1] of the columns below, in order of
/// ids.
struct BoxLists {
  Column<std::size_t> first;     ///< n + 1 entries
  Column<TriangleId> triangles;  ///< for BoxTargets::kTriangles
  Column<std::uint32_t> nodes;   ///< for BoxTargets::kNodes: indices in SceneDescription::nodes
  /// For each box the place where its list would go on; 0 where nothing is left.
  Column<std::uint64_t> next;
};

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
