#pragma once
/// Resolves a TriangleChoice (hit_filter.h) for a scene: which nodes and materials of the scene it
/// names, and which of its entries match nothing.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/column.h"
#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/query/selection_warning.h"
#include "core/scene/scene.h"

namespace sightline {

/// The nodes, materials and triangles that a choice names.
struct ChosenNodes {
  Column<std::uint8_t> node;  ///< 1 or 0, by index in SceneDescription::nodes
  /// 1 or 0, by index in SceneDescription::materials; the last element: no material
  Column<std::uint8_t> material;
  /// Those of the named triangles that have a chosen node and material, ascending; empty: all
  std::optional<std::vector<TriangleId>> triangles;

  /// True if the choice may have triangles of an instance whose primitive has a material.
  /// `its_material` is an index in SceneDescription::materials, or larger for no material.
  bool holds(const Instance& instance, std::uint32_t its_material) const {
    const std::size_t none = material.size() - 1;
    return node[instance.node] != 0 && material[std::min<std::size_t>(its_material, none)] != 0;
  }
};

/// Resolves a choice. `key` is the member of the request that holds the choice ("include"), for
/// JSON pointers. If `warnings` is not null, warnings are appended to it; if it is null, they are
/// errors. Warnings and errors are those of chosen_sides (resolved_filter.h); errors also those of
/// the deadline of `watch`. Throws std::bad_alloc.
Result<ChosenNodes> choose(const Scene& scene, const TriangleChoice& choice, const std::string& key,
                           DeadlineWatch& watch, SelectionWarnings* warnings);

/// The most bytes that choose() allocates for these arguments, its result and warnings included.
std::uint64_t choosing_bytes(const SceneDescription& scene, const TriangleChoice& choice);

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
