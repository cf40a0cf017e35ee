#pragma once
/// Lists the boxes at one level of the trees of a scene, for pictures of the trees.

#include <cstdint>
#include <vector>

#include "core/scene/scene_view.h"

namespace sightline {

/// A box of a node or leaf.
struct LevelBox {
  Box3d box;  ///< in world space
  bool is_leaf = false;
};

/// The boxes of a level.
struct TreeLevel {
  std::vector<LevelBox> boxes;
  bool truncated = false;  ///< there are more boxes than were requested
};

/// Returns at most `most` boxes at `level`; the root is level 0. The levels below a leaf of the top
/// tree are those of the trees of its entries, if they are built and in world space; otherwise the
/// path ends at the leaf. Cost: linear in the size of the levels above. Throws std::bad_alloc.
TreeLevel boxes_of_level(const SceneView& scene, std::uint32_t level, std::size_t most);

}  // namespace sightline

// Tests: tests/integration/parts_test.py
