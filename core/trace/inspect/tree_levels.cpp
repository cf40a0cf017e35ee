#include "core/trace/inspect/tree_levels.h"

#include <cmath>

namespace sightline {

namespace {

struct LevelNode {
  const WideTree* tree;
  std::uint32_t ref, level;
  Box3d box;
};

/// A depth-first walk that ends at the level.
class LevelWalk {
 public:
  explicit LevelWalk(const SceneTree& trees) : trees_(trees) {}

  TreeLevel run(std::uint32_t level, std::size_t most) {
    if (trees_.entries == 1) {
      add_tree(trees_.placements[0], 0);
    } else if (trees_.top.root != ChildRef::kEmpty) {
      waiting_.push_back({&trees_.top, trees_.top.root, 0, trees_.top.bounds});
    }
    TreeLevel found;
    while (!waiting_.empty() && !found.truncated) {
      const LevelNode place = waiting_.back();
      waiting_.pop_back();
      if (place.level < level) {
        descend(place);
      } else if (found.boxes.size() == most) {
        found.truncated = true;
      } else {
        found.boxes.push_back({place.box, ChildRef::is_leaf(place.ref)});
      }
    }
    return found;
  }

 private:
  void descend(const LevelNode& place) {
    if (!ChildRef::is_leaf(place.ref)) return add_children(place);
    if (place.tree != &trees_.top) return;
    for (const LeafBlock& block : place.tree->blocks(place.ref)) {
      for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane)
        add_tree(trees_.placements[block.triangle(lane)], place.level + 1);
    }
  }

  void add_tree(const Placement& placement, std::uint32_t level) {
    if (!placement.world_boxes || trees_.is_unbuilt(placement.tree)) return;
    const WideTree& tree = *trees_.trees[placement.tree];
    if (tree.root != ChildRef::kEmpty) waiting_.push_back({&tree, tree.root, level, tree.bounds});
  }

  void add_children(const LevelNode& place) {
    const WideNode& node = place.tree->node(place.ref);
    const double scale = std::ldexp(1.0, -place.tree->scale_exponent);
    // The first child is the next.
    for (std::size_t i = kArity; i-- > 0;) {
      if (node.child[i] == ChildRef::kEmpty) continue;
      Box3d box;
      for (int k = 0; k < 3; ++k) {
        box.min[k] = static_cast<double>(node.lower[k][i]) * scale;
        box.max[k] = static_cast<double>(node.upper[k][i]) * scale;
      }
      waiting_.push_back({place.tree, node.child[i], place.level + 1, box});
    }
  }

  const SceneTree& trees_;
  std::vector<LevelNode> waiting_;
};

}  // namespace

TreeLevel boxes_of_level(const SceneView& scene, std::uint32_t level, std::size_t most) {
  return LevelWalk(scene.tree()).run(level, most);
}

}  // namespace sightline
