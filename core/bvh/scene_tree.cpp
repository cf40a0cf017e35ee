#include "core/bvh/scene_tree.h"

#include <algorithm>

#include "core/bvh/joining.h"
#include "core/bvh/placing.h"
#include "core/bvh/split.h"
#include "core/bvh/top_tree.h"
#include "core/bvh/tree_source.h"

namespace sightline {

namespace {

/// Joins the placements into one tree of the world, the last entry.
Status add_joined(const ScenePlan& plan, std::span<const std::uint32_t> joined,
                  const TreeSource& source, SceneTree& scene, std::vector<Placement>& placements) {
  std::vector<TreePart> parts;
  std::vector<Placement> behind;
  bool identity = true;
  for (const std::uint32_t i : joined) {
    const PlacementView& view = plan.placements[i];
    behind.push_back(make_placement(i, view, plan.facts[view.mesh]));
    behind.back().tree = static_cast<std::uint32_t>(scene.trees.size());
    identity = identity && behind.back().identity;
    parts.push_back(
        {plan.meshes[view.mesh], behind.back().identity ? nullptr : &view.world_from_mesh});
  }
  auto tree = source.triangles(parts);
  if (!tree) return std::move(tree).error();
  scene.trees.push_back(std::move(*tree));
  if (scene.trees.back()->root == ChildRef::kEmpty) return success();
  for (Placement& placement : behind) placement.identity = identity;
  placements.insert(placements.end(), behind.begin(), behind.end());
  ++scene.entries;
  return success();
}

/// The trees of a mesh: one, or several if it is cut.
struct MeshTrees {
  std::uint32_t first = 0;   ///< index in SceneTree::trees; the others follow
  std::vector<Box3d> boxes;  ///< one for each tree, in its space; of no use for a single tree
};

/// Adds the trees of a placed mesh. `own`: in world space, else in the mesh's own.
Status add_trees(const ScenePlan& plan, std::uint32_t placement, bool own, const TreeSource& source,
                 SceneTree& scene, std::vector<Box3d>& boxes) {
  const PlacementView& view = plan.placements[placement];
  TreePart part{plan.meshes[view.mesh], own ? &view.world_from_mesh : nullptr};
  const auto add = [&](MeshPart cell) -> Status {
    part.runs = cell.runs;
    auto made = source.triangles({&part, 1});
    if (!made) return std::move(made).error();
    scene.trees.push_back(std::move(*made));
    boxes.push_back(cell.box);
    if (source.finished) {
      source.finished(
          {view.mesh, own ? placement : kOwnSpace, std::move(cell), scene.trees.back()});
    }
    return success();
  };
  if (!plan.is_cut(view.mesh)) return add({});
  MeshPart whole;
  whole.box = own ? plan.placed[placement] : plan.facts[view.mesh].box;
  for (MeshPart& cell : cut_mesh(part.mesh, part.world_from_mesh, whole, plan.tree_triangles)) {
    if (Status status = add(std::move(cell)); !status) return status;
  }
  return success();
}

}  // namespace

std::uint64_t SceneTree::bytes() const {
  std::uint64_t sum = top.arena.used();
  for (const auto& tree : trees) {
    if (tree != unbuilt) sum += tree->arena.used();
  }
  return sum;
}

std::uint64_t SceneTree::overflow_bytes() const {
  std::uint64_t sum = 0;
  for (const auto& tree : trees) {
    if (tree->in_overflow) sum += tree->arena.used();
  }
  return sum;
}

Result<SceneTree> assemble_scene_tree(const ScenePlan& plan, Joining joining,
                                      const TreeSource& source) {
  SceneTree scene;
  const std::vector<std::uint32_t> joined =
      joining == Joining::kMeasured
          ? choose_joined(plan.meshes, plan.placements, plan.placed, plan.tree_triangles)
          : std::vector<std::uint32_t>{};

  std::vector<MeshTrees> shared(plan.meshes.size());
  std::vector<Placement> placements;
  std::vector<Box3d> boxes;
  Box3d joined_box;
  std::size_t next_joined = 0;
  for (std::uint32_t i = 0; i < plan.placements.size(); ++i) {
    const PlacementView& view = plan.placements[i];
    const Box3d& box = plan.placed[i];
    if (next_joined < joined.size() && joined[next_joined] == i) {
      joined_box.include(box);
      ++next_joined;
      continue;
    }
    if (box.empty()) continue;

    Placement placement = place_alone(plan, i);
    const bool own = has_own_tree(placement);
    MeshTrees made;
    MeshTrees& trees = own ? made : shared[view.mesh];
    if (trees.boxes.empty()) {
      trees.first = static_cast<std::uint32_t>(scene.trees.size());
      if (Status status = add_trees(plan, i, own, source, scene, trees.boxes); !status)
        return std::move(status).error();
    }
    for (std::size_t k = 0; k < trees.boxes.size(); ++k) {
      placement.tree = trees.first + static_cast<std::uint32_t>(k);
      if (scene.trees[placement.tree]->root == ChildRef::kEmpty) continue;
      placements.push_back(placement);
      ++scene.entries;
      const bool known = trees.boxes.size() > 1 && placement.world_boxes;
      boxes.push_back(known ? trees.boxes[k] : box);
    }
  }
  if (!joined.empty()) {
    if (Status status = add_joined(plan, joined, source, scene, placements); !status)
      return std::move(status).error();
    if (scene.entries > boxes.size()) boxes.push_back(joined_box);
  }
  if (scene.entries > 1) {
    Box3d entered;
    for (const Box3d& box : boxes) entered.include(box);
    auto top = source.top(boxes, entered);
    if (!top) return std::move(top).error();
    scene.top = std::move(*top);
  }
  scene.bounds = plan.bounds;
  std::uint32_t deepest = 0;
  for (const auto& tree : scene.trees) deepest = std::max(deepest, tree->depth);
  scene.depth = scene.top.depth + deepest;
  scene.set_placements(std::move(placements));
  return scene;
}

Result<SceneTree> build_scene_tree(const ScenePlan& plan, TreeQuality quality, Joining joining,
                                   const CancelFlag* cancel,
                                   std::function<void(FinishedTree)> finished) {
  const Error cancelled{ErrorKind::kCancelled, "CANCELLED", "the building of trees was cancelled",
                        ""};
  TreeSource source;
  source.finished = std::move(finished);
  source.triangles =
      [&](std::span<const TreePart> parts) -> Result<std::shared_ptr<const WideTree>> {
    auto tree = std::make_shared<const WideTree>(build_triangle_tree(parts, quality, cancel));
    // Then it is empty, as if there were nothing to hit.
    if (is_cancelled(cancel)) return cancelled;
    return tree;
  };
  source.top = [&](std::span<const Box3d> boxes, const Box3d& all) -> Result<WideTree> {
    WideTree top = build_top(boxes, all, quality, cancel);
    if (is_cancelled(cancel)) return cancelled;
    return top;
  };
  return assemble_scene_tree(plan, joining, source);
}

Result<SceneTree> build_scene_tree(std::span<const MeshView> meshes,
                                   std::span<const PlacementView> placements, TreeQuality quality,
                                   Joining joining) {
  Result<ScenePlan> plan =
      plan_scene({meshes.begin(), meshes.end()}, {placements.begin(), placements.end()});
  if (!plan) return std::move(plan).error();
  return build_scene_tree(*plan, quality, joining);
}

}  // namespace sightline
