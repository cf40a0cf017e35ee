#pragma once
/// Which triangles of a scene count: by the side that a ray meets, by node and by material.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/column.h"
#include "core/base/watch.h"
#include "core/query/hit_batch.h"

namespace sightline {

/// Which sides of triangles are culled. The front of a triangle is its counter-clockwise side. The
/// sign of direction . normal decides, exactly. A ray in the plane of a triangle meets neither
/// side, so it hits only with kNothing.
enum class Culling {
  kNothing,
  kBack,      ///< hits on fronts count
  kFront,     ///< hits on backs count
  kMaterial,  ///< as kBack, except where the material is double-sided [glTF2]
};

/// Some of a scene's triangles: those below any of the named nodes (anywhere, if none of `nodes`
/// and `names` is given) with any of the named materials (any, if not given).
struct TriangleChoice {
  std::optional<std::vector<std::uint32_t>> nodes;    ///< indices in the file, with all below them
  std::optional<std::vector<std::string>> names;      ///< globs of node names, with all below them
  std::optional<std::vector<std::string>> materials;  ///< globs of material names
};

/// A filter as a client states it.
struct HitFilter {
  Culling culling = Culling::kNothing;
  std::optional<TriangleChoice> include;  ///< nothing else counts
  std::optional<TriangleChoice> exclude;  ///< does not count, included or not
  std::uint32_t mask = 0xffffffffu;       ///< only nodes whose mask has a bit in common count

  bool accepts_all() const {
    return culling == Culling::kNothing && !include && !exclude && mask == 0xffffffffu;
  }
};

/// A resolved filter: which sides of every primitive of every instance of a scene count.
struct ResolvedFilter {
  static constexpr std::uint8_t kFront = 1, kBack = 2, kEdgeOn = 4, kAll = 7;

  Column<std::size_t> first;   ///< of each instance in `sides`
  Column<std::uint8_t> sides;  ///< by instance and primitive
  /// By instance, to be compared with that of each ray; empty where they need not be.
  Column<std::uint32_t> masks = {};
};

/// `*` stands for any text, `?` for one character of UTF-8; everything else for itself. False also
/// where the watch has passed. Cost: mostly one step for each character, at worst (many places
/// where a long part nearly matches) the product of the lengths.
bool glob_matches(std::string_view pattern, std::string_view text, DeadlineWatch& watch);

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
