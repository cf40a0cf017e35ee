#pragma once
/// The boxes of one level of the trees of a scene.

#include <cstdint>
#include <vector>

#include "core/scene/scene_view.h"

namespace sightline {

struct LevelBox {
  Box3d box;  ///< in the world
  bool is_leaf = false;
};

struct TreeLevel {
  std::vector<LevelBox> boxes;
  bool truncated = false;
};

/// Boxes at `level`: the root is level 0. Below a leaf of the tree over the placements come the
/// trees of these, unless they are in the space of a mesh or not built yet: then the leaf ends it.
/// At most `most` boxes. Cost: linear in the levels above. Throws std::bad_alloc.
TreeLevel boxes_of_level(const SceneView& scene, std::uint32_t level, std::size_t most);

}  // namespace sightline

// Tests: tests/integration/parts_test.py
