#include "core/bvh/lazy_layout.h"

#include <algorithm>

#include "core/bvh/placing.h"
#include "core/bvh/top_tree.h"
#include "core/bvh/triangle_tree.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

/// Smaller meshes are built sooner than cut.
constexpr std::uint32_t kSplitAbove = 1u << 17;

/// A first ray needs only some of its parts.
bool has_small_parts(const TreeSlot& slot) {
  return slot.entries == 1 && !slot.whole && slot.triangle_count > kSplitAbove;
}

const Affine* matrix_of(const ScenePlan& plan, const TreeSlot& slot) {
  return slot.placement == kOwnSpace ? nullptr : &plan.placements[slot.placement].world_from_mesh;
}

}  // namespace

LazyLayout::WithState LazyLayout::unbuilt(const ScenePlan& plan) {
  constexpr std::uint32_t kNoSlot = 0xffffffffu;
  WithState made{LazyLayout(plan), {}};
  std::vector<TreeSlot>& slots = made.layout.slots_;
  std::vector<std::uint32_t> shared(plan.meshes.size(), kNoSlot);
  std::vector<Placement> placements;
  placements.reserve(plan.placements.size());
  made.layout.boxes_.reserve(plan.placements.size());
  for (std::uint32_t i = 0; i < plan.placements.size(); ++i) {
    const PlacementView& view = plan.placements[i];
    if (plan.placed[i].empty()) continue;
    Placement& placement = placements.emplace_back(place_alone(plan, i));
    const bool own = has_own_tree(placement);
    std::uint32_t& slot = shared[view.mesh];
    if (own || slot == kNoSlot) {
      placement.tree = static_cast<std::uint32_t>(slots.size());
      slots.push_back({.mesh = view.mesh,
                       .placement = own ? i : kOwnSpace,
                       .triangle_count = plan.meshes[view.mesh].triangle_count(),
                       .whole = !placement.world_boxes,
                       .box = plan.placed[i]});
      if (!own) slot = placement.tree;
    } else {
      placement.tree = slot;
    }
    ++slots[placement.tree].entries;
    slots[placement.tree].whole |= !placement.world_boxes;
    made.layout.boxes_.push_back(plan.placed[i]);
  }
  SceneTree& tree = made.tree;
  made.layout.place(std::move(placements), tree);
  tree.unbuilt = make_empty_tree();
  tree.trees.assign(slots.size(), tree.unbuilt);
  tree.unbuilt_count = static_cast<std::uint32_t>(slots.size());
  tree.depth = tree.top.depth + tree.unbuilt->depth;
  return made;
}

void LazyLayout::place(std::vector<Placement> placements, SceneTree& tree) const {
  tree.bounds = plan_.bounds;
  tree.entries = static_cast<std::uint32_t>(boxes_.size());
  tree.set_placements(std::move(placements));
  tree.top = {};
  // Rays search it for unbuilt trees even if there is only one entry.
  if (tree.entries == 0) return;
  tree.top_memory =
      std::make_shared<const WideTree>(build_top(boxes_, tree.bounds, TreeQuality::kFast));
  tree.top = WideTree::alias(tree.top_memory);
}

SceneTree LazyLayout::split(std::uint32_t slot, std::vector<MeshPart> parts,
                            const SceneTree& tree) {
  const TreeSlot whole = slots_[slot];
  SceneTree next = share(tree);
  std::vector<Placement> placements;
  placements.reserve(tree.placements.size() - whole.entries + parts.size() * whole.entries);
  std::vector<Box3d> boxes;
  boxes.reserve(tree.entries - whole.entries + parts.size() * whole.entries);
  // Entries that the parts replace, by their indices in `tree`.
  std::vector<std::uint32_t> replaced;
  // The last entry stays the last if others share its tree.
  const std::uint32_t behind = tree.entries - (tree.placements.size() > tree.entries ? 1 : 0);
  for (std::uint32_t i = 0; i < behind; ++i) {
    if (tree.placements[i].tree == slot) {
      replaced.push_back(i);
    } else {
      placements.push_back(tree.placements[i]);
      boxes.push_back(boxes_[i]);
    }
  }
  for (MeshPart& part : parts) {
    for (const std::uint32_t i : replaced) {
      placements.push_back(tree.placements[i]);
      placements.back().tree = static_cast<std::uint32_t>(slots_.size());
      // Boxes of a mesh's own space say little about the world.
      boxes.push_back(placements.back().world_boxes ? part.box : boxes_[i]);
    }
    slots_.push_back(whole);
    slots_.back().triangle_count = part.triangle_count;
    slots_.back().whole = whole.whole || parts.size() < 2;
    slots_.back().box = part.box;
    slots_.back().runs = part.runs;
    slots_.back().owner = std::move(part.owner);
    next.trees.push_back(next.unbuilt);
    ++next.unbuilt_count;
  }
  const auto rest = tree.placements.subspan(behind);
  placements.insert(placements.end(), rest.begin(), rest.end());
  boxes.insert(boxes.end(), boxes_.begin() + behind, boxes_.end());
  boxes_ = std::move(boxes);
  slots_[slot] = {};
  next.trees[slot] = make_empty_tree();
  --next.unbuilt_count;
  place(std::move(placements), next);
  next.depth += next.top.depth - tree.top.depth;
  return next;
}

bool can_split(const ScenePlan& plan, const TreeSlot& slot) {
  return has_small_parts(slot) || slot.triangle_count > plan.tree_triangles;
}

std::vector<MeshPart> split_slot(const ScenePlan& plan, const TreeSlot& slot) {
  const MeshView& mesh = plan.meshes[slot.mesh];
  const Affine* matrix = matrix_of(plan, slot);
  // The box that assemble_scene_tree cuts a whole mesh in: its trees then have whole parts in them.
  const bool is_all = matrix == nullptr && slot.runs.empty() && plan.is_cut(slot.mesh);
  const Box3d& box = is_all ? plan.facts[slot.mesh].box : slot.box;
  if (has_small_parts(slot)) return split_mesh(mesh, matrix, numbers_of(slot.runs), box);
  return cut_mesh(
      mesh, matrix,
      {.runs = slot.runs, .triangle_count = slot.triangle_count, .owner = {}, .box = box},
      plan.tree_triangles);
}

WideTree build_slot(const ScenePlan& plan, const TreeSlot& slot, TreeQuality quality,
                    const CancelFlag* cancel) {
  const std::vector<TriangleRun> runs = ascending(slot.runs);
  const TreePart part{plan.meshes[slot.mesh], matrix_of(plan, slot), runs};
  return build_triangle_tree({&part, 1}, quality, cancel);
}

SceneTree share(const SceneTree& tree) {
  SceneTree same;
  same.trees = tree.trees;
  same.placement_memory = tree.placement_memory;
  same.placements = tree.placements;
  same.entries = tree.entries;
  same.top_memory = tree.top_memory;
  if (tree.top_memory) same.top = WideTree::alias(tree.top_memory);
  same.bounds = tree.bounds;
  same.depth = tree.depth;
  same.unbuilt = tree.unbuilt;
  same.unbuilt_count = tree.unbuilt_count;
  return same;
}

std::shared_ptr<const WideTree> make_empty_tree() {
  auto tree = std::make_shared<WideTree>();
  tree->arena = Arena(sizeof(WideNode));
  tree->arena.take(sizeof(WideNode));
  auto& node = *reinterpret_cast<WideNode*>(tree->arena.at(0));
  std::uint32_t forward = 0;
  for (std::uint32_t i = 0; i < kArity; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      node.lower[k][i] = kInfF;
      node.upper[k][i] = -kInfF;
    }
    node.child[i] = ChildRef::kEmpty;
    forward |= i << (3 * i);
  }
  for (std::uint32_t& order : node.order) order = forward;
  tree->root = ChildRef::node(0);
  tree->node_count = 1;
  tree->depth = 1;
  return tree;
}

}  // namespace sightline
