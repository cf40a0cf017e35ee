#include "core/bvh/scene_tree.h"

#include <algorithm>

#include "core/bvh/joining.h"
#include "core/bvh/placing.h"
#include "core/bvh/top_tree.h"
#include "core/bvh/triangle_tree.h"

namespace sightline {

namespace {

/// Puts the placements together into one tree of the world, the last entry.
void add_joined(const ScenePlan& plan, std::span<const std::uint32_t> joined, TreeQuality quality,
                SceneTree& scene, std::vector<Placement>& placements) {
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
  auto tree = std::make_shared<const WideTree>(build_triangle_tree(parts, quality));
  if (tree->root == ChildRef::kEmpty) return;
  for (Placement& placement : behind) placement.identity = identity;
  scene.trees.push_back(std::move(tree));
  placements.insert(placements.end(), behind.begin(), behind.end());
  ++scene.entries;
}

}  // namespace

std::uint64_t SceneTree::bytes() const {
  std::uint64_t sum = top.arena.used();
  for (const auto& tree : trees) {
    if (tree != unbuilt) sum += tree->arena.used();
  }
  return sum;
}

Result<SceneTree> build_scene_tree(const ScenePlan& plan, TreeQuality quality, Joining joining) {
  SceneTree scene;
  const std::vector<std::uint32_t> joined =
      joining == Joining::kMeasured ? choose_joined(plan.meshes, plan.placements, plan.placed)
                                    : std::vector<std::uint32_t>{};

  constexpr std::uint32_t kNoTree = 0xffffffffu;
  std::vector<std::uint32_t> shared(plan.meshes.size(), kNoTree);
  std::vector<Placement> placements;
  std::vector<Box3d> bounds;
  Box3d joined_bounds;
  std::size_t next_joined = 0;
  for (std::uint32_t i = 0; i < plan.placements.size(); ++i) {
    const PlacementView& view = plan.placements[i];
    const MeshView& mesh = plan.meshes[view.mesh];
    const Box3d& box = plan.placed[i];
    if (next_joined < joined.size() && joined[next_joined] == i) {
      joined_bounds.include(box);
      ++next_joined;
      continue;
    }
    if (box.empty()) continue;

    Placement placement = make_placement(i, view, plan.facts[view.mesh]);
    const bool mapped = is_mapped(plan, i, placement.space);
    placement.world_boxes = !mapped;
    const bool own = !placement.identity && !mapped;
    std::uint32_t& tree = shared[view.mesh];
    if (own || tree == kNoTree) {
      scene.trees.push_back(std::make_shared<const WideTree>(
          build_triangle_tree(mesh, own ? &view.world_from_mesh : nullptr, quality)));
      placement.tree = static_cast<std::uint32_t>(scene.trees.size() - 1);
      if (!own) tree = placement.tree;
    } else {
      placement.tree = tree;
    }
    if (scene.trees[placement.tree]->root == ChildRef::kEmpty) continue;
    placements.push_back(placement);
    ++scene.entries;
    bounds.push_back(box);
  }
  if (!joined.empty()) {
    const std::uint32_t before = scene.entries;
    add_joined(plan, joined, quality, scene, placements);
    if (scene.entries > before) bounds.push_back(joined_bounds);
  }
  scene.bounds = plan.bounds;
  if (scene.entries > 1) scene.top = build_top(bounds, scene.bounds, quality);
  std::uint32_t deepest = 0;
  for (const auto& tree : scene.trees) deepest = std::max(deepest, tree->depth);
  scene.depth = scene.top.depth + deepest;
  scene.set_placements(std::move(placements));
  return scene;
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
