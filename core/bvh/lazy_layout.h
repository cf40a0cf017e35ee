#pragma once
/// Which trees a scene may build one by one, when rays come near them, and what is entered for
/// each.

#include <cstdint>
#include <memory>
#include <vector>

#include "core/bvh/scene_tree.h"
#include "core/bvh/split.h"

namespace sightline {

/// A tree that can be built on its own: of a mesh in its own space, of a placed mesh in the world,
/// or of a part of one.
struct TreeSlot {
  static constexpr std::uint32_t kOwnSpace = 0xffffffffu;

  std::uint32_t mesh = 0;
  /// The placement of the plan whose world triangles the tree is around.
  std::uint32_t placement = kOwnSpace;
  std::uint32_t triangle_count = 0;
  std::uint32_t entries = 0;  ///< that enter it
  /// Never cut: rays are mapped into its space, or its triangles lie around one place.
  bool whole = false;
  Box3d box = {};                          ///< of what its single entry may hit, in the world
  std::span<const TriangleRun> runs = {};  ///< empty: all of the mesh
  std::shared_ptr<const void> owner = {};  ///< of the runs
};

/// Slots are never renumbered: those of a split are added at the end. The plan outlives it.
class LazyLayout {
 public:
  /// Every placement with something finite is entered on its own. Throws std::bad_alloc.
  explicit LazyLayout(const ScenePlan& plan);

  const std::vector<TreeSlot>& slots() const { return slots_; }
  /// A state in which every slot is unbuilt.
  SceneTree unbuilt() const;
  /// Enters the parts in place of the slot, which nothing enters any more. `tree` is a state of
  /// this layout. Returns that state with the parts unbuilt. Precondition: can_split.
  SceneTree split(std::uint32_t slot, std::vector<MeshPart> parts, const SceneTree& tree);

  /// The layout after moved_plan changed the placements `moved`; `tree` was a state of the plan
  /// before. Trees of what has not moved are reused, and so are trees in a moved mesh's own space.
  /// A tree that several placements share in the world is copied without the moved ones, which are
  /// entered on their own from then on. Trees that are missing count as unbuilt.
  ///
  /// before  the layout that `tree` is a state of; null where `tree` has the lasting form
  struct Moved;
  static Moved moved(const ScenePlan& plan, const LazyLayout* before, const SceneTree& tree,
                     std::span<const std::uint32_t> moved);

 private:
  explicit LazyLayout(const ScenePlan* plan) : plan_(*plan) {}
  void place(SceneTree& tree) const;
  /// Placements that share the last tree stay behind all others.
  void enter(const Placement& placement, const Box3d& box);
  void carry_shared(std::span<const Placement> shared, const std::vector<bool>& is_moved,
                    const SceneTree& from, SceneTree& to);

  const ScenePlan& plan_;
  std::vector<TreeSlot> slots_;
  std::vector<Placement> placements_;  ///< one for each entry
  std::vector<Box3d> boxes_;           ///< likewise, in the world
  /// Placements that share the tree of the last entry. A placement that has left it has the
  /// instance kGone.
  std::vector<Placement> behind_;

  static constexpr std::uint32_t kGone = 0xffffffffu;
};

struct LazyLayout::Moved {
  LazyLayout layout;
  SceneTree tree;
};

/// Whether what a first ray needs of it is little of the whole.
bool can_split(const TreeSlot& slot);
/// Parallel. Precondition: can_split.
std::vector<MeshPart> split_slot(const ScenePlan& plan, const TreeSlot& slot);
/// Parallel. Leaves name triangles by their number in the mesh. Empty once it is cancelled.
WideTree build_slot(const ScenePlan& plan, const TreeSlot& slot, TreeQuality quality,
                    const CancelFlag* cancel = nullptr);

/// A state with the trees of `tree`.
SceneTree share(const SceneTree& tree);

/// A tree that is entered in vain.
std::shared_ptr<const WideTree> make_barren_tree();

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
