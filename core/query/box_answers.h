#pragma once
/// The options of queries that find the triangles or nodes of a scene in boxes, and the answers as
/// columns.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/vec3.h"
#include "core/query/hit_batch.h"

namespace sightline {

/// What a box query counts and lists.
enum class BoxTargets {
  kTriangles,
  kNodes,  ///< nodes of the file; a node counts if one of its instances has a triangle that counts
};

/// When a triangle counts for a box. A box may be any shape of BoxBatch.
enum class BoxRelation {
  kIntersecting,  ///< it has a point in the closed box
  /// It lies wholly in the closed box. A node counts if it has triangles and all of them lie in the
  /// box; triangles without area are ignored.
  kContained,
};

/// The options of a box query.
struct BoxQuestion {
  BoxTargets targets;
  BoxRelation relation;
  /// For each box the place (list_place) at which its list begins; the total ignores it. Empty:
  /// every list begins at the first item.
  Column<std::uint64_t> from;
  bool contacts = false;  ///< the answer has the contact of each triangle too

  // NOLINTNEXTLINE(*-explicit-*): most questions are just that
  BoxQuestion(BoxTargets of = BoxTargets::kTriangles,
              BoxRelation which = BoxRelation::kIntersecting)
      : targets(of), relation(which) {}
  /// The place at which the list of box i begins.
  std::uint64_t from_of(std::size_t i) const { return from.empty() ? 0 : from[i]; }
};

/// How many entries the lists may have.
struct ListLimits {
  std::size_t each = 0;   ///< each list has the first items from its place on, up to this number
  std::size_t total = 0;  ///< if all lists have more items than this in total, the query fails
};

/// The place of a triangle or a node in a list: its sort key. A list that begins at a place has the
/// items whose key is at least that place.
inline std::uint64_t list_place(const TriangleId& id) {
  return std::uint64_t{id.instance} << 32 | id.triangle;
}
inline std::uint64_t list_place(std::uint32_t node) { return node; }

/// The lists of n boxes, each of the items that count for one box. The items of box i are the
/// elements first[i] .. first[i+1] - 1 of `triangles` or `nodes`, sorted by id.
struct BoxLists {
  Column<std::size_t> first;     ///< n + 1 elements
  Column<TriangleId> triangles;  ///< set for BoxTargets::kTriangles, else empty
  Column<std::uint32_t> nodes;   ///< set for BoxTargets::kNodes: indices in SceneDescription::nodes
  /// For each box the place at which its list would go on; 0 if it is complete or no item was
  /// listed.
  Column<std::uint64_t> next;
};

/// How deep the shape of a list is in each of its triangles, and along which direction it comes out
/// first (core/geometry/convex/shape_contact.h). Element i belongs to BoxLists::triangles[i].
struct BoxContacts {
  Column<double> depth;  ///< +inf: no translation separates both
  Column<Vec3d> normal;  ///< unit; zero if no translation separates both
};

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
