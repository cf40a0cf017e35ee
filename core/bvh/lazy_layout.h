#pragma once
/// LazyLayout: which trees of a scene can be built one by one, on demand, and the states of the scene
/// (SceneTree) between none of them and all.

#include <cstdint>
#include <memory>
#include <vector>

#include "core/bvh/scene_tree.h"
#include "core/bvh/split.h"

namespace sightline {

/// A tree that can be built on its own: of a mesh in its own space, of a placed mesh in world
/// space, or of a part of either. Slot i describes SceneTree::trees[i].
struct TreeSlot {
  /// Index in ScenePlan::meshes.
  std::uint32_t mesh = 0;
  /// Index in ScenePlan::placements if the tree is around the world triangles of that placement;
  /// kOwnSpace if it is in the mesh's own space.
  std::uint32_t placement = kOwnSpace;
  std::uint32_t triangle_count = 0;
  std::uint32_t entries = 0;  ///< number of entries (SceneTree) that use this tree
  /// True if the tree is split only if it is too large (ScenePlan::tree_triangles): rays are mapped
  /// into its space, or its triangles are all around one place.
  bool whole = false;
  Box3d box = {};  ///< world bounds of the triangles, if only one entry uses the tree
  std::span<const TriangleRun> runs = {};  ///< the triangles of the tree; empty: all of the mesh
  std::shared_ptr<const void> owner = {};  ///< owns the memory of `runs`
};

/// The list of slots, one for each tree, and a box for each entry of the present state. The entries
/// are in that state, which the layout makes: split() and moved() need exactly the last one. Slots
/// are never renumbered: a split appends the new ones. A layout does not build trees: its owner
/// builds them by build_slot, and puts them into SceneTree::trees. Not thread-safe. The plan must
/// outlive the layout.
class LazyLayout {
 public:
  struct WithState;
  /// Makes an entry for each placement that has a finite triangle, and the state in which no slot is
  /// built. Throws std::bad_alloc.
  static WithState unbuilt(const ScenePlan& plan);

  /// The slots; a split may move their memory.
  const std::vector<TreeSlot>& slots() const { return slots_; }
  /// Replaces a slot by its parts (split_slot): each entry of the slot becomes one entry for each
  /// part. The slot retains its number and has an empty tree. `tree` is the present state of this
  /// layout; returns the state with the parts unbuilt. Precondition: can_split(plan, slot). Throws
  /// std::bad_alloc.
  SceneTree split(std::uint32_t slot, std::vector<MeshPart> parts, const SceneTree& tree);

  /// Replaces slots by finished trees of their triangles; the returned state does not refer to the
  /// trees that these slots had. A finished tree is left out unless its triangles are those of
  /// some slots exactly. A tree that replaces several slots has a new slot, and the old ones retain
  /// their numbers and have an empty tree. Changes nothing if placements share the tree of the last
  /// entry. `tree` is the present state of this layout. Throws std::bad_alloc, and then changes
  /// nothing.
  SceneTree replace(std::span<const FinishedTree> finished, const SceneTree& tree);

  /// The layout after moved_plan changed the placements `moved` and the content of the meshes
  /// `fresh`, and its state. `plan` is the result of moved_plan and must outlive the layout. `tree`
  /// is the state of `plan_before`.
  /// Trees of placements that did not move are reused, and so are trees in a moved mesh's own
  /// space. A tree that several placements share in world space is copied without the moved
  /// placements, which become entries of their own. Trees that are missing are marked as unbuilt.
  /// Throws std::bad_alloc.
  ///
  /// before  the layout of the state `tree`; null if all trees of `tree` were built at once
  ///         (scene_tree.h)
  static WithState moved(const ScenePlan& plan, const ScenePlan& plan_before,
                         const LazyLayout* before, const SceneTree& tree,
                         std::span<const std::uint32_t> moved,
                         std::span<const std::uint32_t> fresh);

 private:
  explicit LazyLayout(const ScenePlan& plan) : plan_(plan) {}
  /// Sets the placements, entries and bounds, and builds the top tree. `placements` are one for each
  /// of boxes_, and then those that share the tree of the last entry.
  void place(std::vector<Placement> placements, SceneTree& tree) const;
  void carry_shared(std::span<const Placement> shared, const std::vector<bool>& is_moved,
                    const SceneTree& from, SceneTree& to, std::vector<Placement>& placements);

  const ScenePlan& plan_;
  std::vector<TreeSlot> slots_;
  std::vector<Box3d> boxes_;  ///< world bounds of each entry

  /// Placement::instance of a placement that has left the tree of the last entry.
  static constexpr std::uint32_t kGone = 0xffffffffu;
};

/// A layout and the state that it begins with.
struct LazyLayout::WithState {
  LazyLayout layout;
  SceneTree tree;
};

/// True if the slot is too large for one tree. Also true if it is not `whole`, has one entry, and
/// has more than 2^17 triangles: a first ray needs only a small part of them.
bool can_split(const ScenePlan& plan, const TreeSlot& slot);
/// Divides the triangles of a slot into parts of neighbours (split.h). Parallel. Precondition:
/// can_split(plan, slot). Throws std::bad_alloc.
std::vector<MeshPart> split_slot(const ScenePlan& plan, const TreeSlot& slot);
/// Builds the tree of a slot. Leaves hold the triangles' numbers in the mesh. Parallel. Returns an
/// empty tree if cancelled; `cancel` may be null. Throws std::bad_alloc.
WideTree build_slot(const ScenePlan& plan, const TreeSlot& slot, TreeQuality quality,
                    const CancelFlag* cancel = nullptr);

/// Returns a copy of a state that shares its trees and placements. Precondition: tree.top is empty
/// or an alias of top_memory, as layouts make it.
SceneTree share(const SceneTree& tree);

/// Makes a tree of one node without children: a ray that enters it hits nothing. Never null.
std::shared_ptr<const WideTree> make_empty_tree();

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
