#pragma once
/// What boxes touch, as columns.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/query/hit_batch.h"

namespace sightline {

/// What a box query counts and lists.
enum class BoxTargets {
  kTriangles,
  kNodes,  ///< nodes of the file, one of whose instances has a triangle that touches the box
};

/// What box i touches: entries first[i] .. first[i+1] of the columns below, in order of ids.
struct BoxLists {
  Column<std::size_t> first;     ///< n + 1 entries
  Column<TriangleId> triangles;  ///< for BoxTargets::kTriangles
  Column<std::uint32_t> nodes;   ///< for BoxTargets::kNodes: indices in SceneDescription::nodes
};

}  // namespace sightline
