#pragma once
/// Filters of hits: by the side of a triangle that a ray meets, by node, by material and by mask.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/column.h"
#include "core/base/watch.h"
#include "core/query/hit_batch.h"

namespace sightline {

/// Which sides of triangles are culled: rays pass through them. The front of a triangle is the side
/// from which its corners run counter-clockwise. The exact sign of direction . normal decides which
/// side a ray meets. A ray in the plane of a triangle meets neither side, so it hits the triangle
/// only if none of its sides is culled.
enum class Culling {
  kNothing,
  kBack,      ///< hits on fronts count
  kFront,     ///< hits on backs count
  kMaterial,  ///< like kBack, but both sides count if the material is double-sided [glTF2]
};

/// A choice of triangles: those of the chosen nodes that have one of the chosen materials and are in
/// `triangles`. A node is chosen by `nodes` or by `names`. Without `nodes` and `names` all nodes are
/// chosen, without `materials` all materials, without `triangles` all triangles. An empty list names
/// nothing.
struct TriangleChoice {
  /// indices in the file's "nodes"; the nodes below them are chosen too
  std::optional<std::vector<std::uint32_t>> nodes;
  /// glob patterns (glob_matches) of node names; the nodes below matching nodes are chosen too
  std::optional<std::vector<std::string>> names;
  std::optional<std::vector<std::string>> materials;  ///< glob patterns of material names
  std::optional<std::vector<TriangleName>> triangles = {};
};

/// A filter in the terms of a client's request. resolve_filter (core/run/resolved_filter.h) turns
/// it into a ResolvedFilter.
struct HitFilter {
  Culling culling = Culling::kNothing;
  std::optional<TriangleChoice> include;  ///< if set, only these triangles count
  /// if set, these triangles do not count, even if included
  std::optional<TriangleChoice> exclude;
  /// Only instances whose mask (Instance::mask) shares a bit with it count.
  std::uint32_t mask = 0xffffffffu;

  /// True if the filter excludes nothing, except instances whose own mask is 0.
  bool accepts_all() const {
    return culling == Culling::kNothing && !include && !exclude && mask == 0xffffffffu;
  }
};

/// A filter resolved for a scene: which sides of every primitive of every instance count. It is
/// valid only for the scene for which it was resolved.
struct ResolvedFilter {
  /// The bits of an element of `sides`; kEdgeOn stands for a ray in the plane of the triangle. 0:
  /// the primitive does not count.
  static constexpr std::uint8_t kFront = 1, kBack = 2, kEdgeOn = 4, kAll = 7;

  Column<std::size_t> first;   ///< by instance: index in `sides` of its first primitive
  Column<std::uint8_t> sides;  ///< for each primitive of each instance, the set of sides that count
  /// By instance: its mask, which is compared with that of each ray (RayBatch::mask). Empty if
  /// masks of rays exclude nothing.
  Column<std::uint32_t> masks = {};
  /// If set, only these triangles count, of the sides above. Ascending.
  std::optional<std::vector<TriangleId>> only = {};
  std::vector<TriangleId> without = {};  ///< these triangles do not count; ascending

  /// True if single triangles are named: `sides` does not decide alone.
  bool names_triangles() const { return only || !without.empty(); }
};

/// True if the pattern matches the whole text: `*` stands for any text, `?` for one character of
/// UTF-8, everything else for itself. Also false if the deadline of `watch` passes. Cost: mostly
/// one step for each character. At worst, with many partial matches of a long part of the pattern,
/// the product of the lengths.
bool glob_matches(std::string_view pattern, std::string_view text, DeadlineWatch& watch);

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
