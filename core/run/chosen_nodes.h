#pragma once
/// Which nodes and materials of a scene a choice names, and which of its entries name none.

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

struct ChosenNodes {
  Column<std::uint8_t> node;      ///< 1 or 0, by SceneDescription::nodes
  Column<std::uint8_t> material;  ///< by SceneDescription::materials; the last one: no material

  bool holds(const Instance& instance, std::uint32_t its_material) const {
    const std::size_t none = material.size() - 1;
    return node[instance.node] != 0 && material[std::min<std::size_t>(its_material, none)] != 0;
  }
};

/// `key` is the member of the question that holds the choice. Warnings and errors: those of
/// chosen_sides (resolved_filter.h), and those of the watch.
Result<ChosenNodes> choose(const SceneDescription& scene, const TriangleChoice& choice,
                           const std::string& key, DeadlineWatch& watch,
                           SelectionWarnings* warnings);

/// Bytes that choose() takes at most, its result and its warnings included.
std::uint64_t choosing_bytes(const SceneDescription& scene, const TriangleChoice& choice);

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
