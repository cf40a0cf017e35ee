#pragma once
/// Resolves a TriangleChoice: which nodes and materials of a scene it names, and which of its
/// entries match nothing.

#include <algorithm>
#include <cstdint>
#include <string>

#include "core/base/column.h"
#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/query/selection_warning.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// The nodes and materials that a choice names.
struct ChosenNodes {
  Column<std::uint8_t> node;  ///< 1 or 0, by index in SceneDescription::nodes
  /// 1 or 0, by index in SceneDescription::materials; the last element: no material
  Column<std::uint8_t> material;

  /// True if the triangles of an instance with a material are chosen.
  bool holds(const Instance& instance, std::uint32_t its_material) const {
    const std::size_t none = material.size() - 1;
    return node[instance.node] != 0 && material[std::min<std::size_t>(its_material, none)] != 0;
  }
};

/// Resolves a choice. `key` is the member of the question that holds the choice, for pointers.
/// Warnings and errors are those of chosen_sides (resolved_filter.h); if `warnings` is null, they
/// are all errors. Errors also of the deadline of `watch`.
Result<ChosenNodes> choose(const SceneDescription& scene, const TriangleChoice& choice,
                           const std::string& key, DeadlineWatch& watch,
                           SelectionWarnings* warnings);

/// The most bytes that choose() allocates, its result and warnings included.
std::uint64_t choosing_bytes(const SceneDescription& scene, const TriangleChoice& choice);

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
