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
  return slot.placement == TreeSlot::kOwnSpace ? nullptr
                                               : &plan.placements[slot.placement].world_from_mesh;
}

}  // namespace

LazyLayout::LazyLayout(const ScenePlan& plan) : plan_(plan) {
  constexpr std::uint32_t kNoSlot = 0xffffffffu;
  std::vector<std::uint32_t> shared(plan.meshes.size(), kNoSlot);
  placements_.reserve(plan.placements.size());
  boxes_.reserve(plan.placements.size());
  for (std::uint32_t i = 0; i < plan.placements.size(); ++i) {
    const PlacementView& view = plan.placements[i];
    if (plan.placed[i].empty()) continue;
    Placement placement = place_alone(plan, i);
    const bool own = has_own_tree(placement);
    std::uint32_t& slot = shared[view.mesh];
    if (own || slot == kNoSlot) {
      placement.tree = static_cast<std::uint32_t>(slots_.size());
      slots_.push_back({.mesh = view.mesh,
                        .placement = own ? i : TreeSlot::kOwnSpace,
                        .triangle_count = plan.meshes[view.mesh].triangle_count(),
                        .whole = !placement.world_boxes,
                        .box = plan.placed[i]});
      if (!own) slot = placement.tree;
    } else {
      placement.tree = slot;
    }
    ++slots_[placement.tree].entries;
    slots_[placement.tree].whole |= !placement.world_boxes;
    placements_.push_back(placement);
    boxes_.push_back(plan.placed[i]);
  }
}

void LazyLayout::place(SceneTree& tree) const {
  tree.bounds = plan_.bounds;
  tree.entries = static_cast<std::uint32_t>(placements_.size());
  std::vector<Placement> all;
  all.reserve(placements_.size() + behind_.size());
  all.insert(all.end(), placements_.begin(), placements_.end());
  all.insert(all.end(), behind_.begin(), behind_.end());
  tree.set_placements(std::move(all));
  tree.top = {};
  // Rays search it for unbuilt trees even if there is only one entry.
  if (tree.entries == 0) return;
  tree.top_memory =
      std::make_shared<const WideTree>(build_top(boxes_, tree.bounds, TreeQuality::kFast));
  tree.top = WideTree::alias(tree.top_memory);
}

void LazyLayout::enter(const Placement& placement, const Box3d& box) {
  const std::size_t last = placements_.size() - (behind_.empty() ? 0 : 1);
  placements_.insert(placements_.begin() + static_cast<std::ptrdiff_t>(last), placement);
  boxes_.insert(boxes_.begin() + static_cast<std::ptrdiff_t>(last), box);
}

SceneTree LazyLayout::unbuilt() const {
  SceneTree tree;
  place(tree);
  tree.unbuilt = make_empty_tree();
  tree.trees.assign(slots_.size(), tree.unbuilt);
  tree.unbuilt_count = static_cast<std::uint32_t>(slots_.size());
  tree.depth = tree.top.depth + tree.unbuilt->depth;
  return tree;
}

SceneTree LazyLayout::split(std::uint32_t slot, std::vector<MeshPart> parts,
                            const SceneTree& tree) {
  const TreeSlot whole = slots_[slot];
  SceneTree next = share(tree);
  std::vector<Placement> entries;
  std::vector<Box3d> boxes;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    if (placements_[i].tree == slot) {
      entries.push_back(placements_[i]);
      boxes.push_back(boxes_[i]);
      continue;
    }
    placements_[kept] = placements_[i];
    boxes_[kept++] = boxes_[i];
  }
  placements_.resize(kept);
  boxes_.resize(kept);
  for (MeshPart& part : parts) {
    for (std::size_t i = 0; i < entries.size(); ++i) {
      entries[i].tree = static_cast<std::uint32_t>(slots_.size());
      // Boxes of a mesh's own space say little about the world.
      enter(entries[i], entries[i].world_boxes ? part.box : boxes[i]);
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
  slots_[slot] = {};
  next.trees[slot] = make_empty_tree();
  --next.unbuilt_count;
  place(next);
  next.depth += next.top.depth - tree.top.depth;
  return next;
}

bool can_split(const ScenePlan& plan, const TreeSlot& slot) {
  return has_small_parts(slot) || slot.triangle_count > plan.tree_triangles;
}

std::vector<MeshPart> split_slot(const ScenePlan& plan, const TreeSlot& slot) {
  const MeshView& mesh = plan.meshes[slot.mesh];
  const Affine* matrix = matrix_of(plan, slot);
  if (has_small_parts(slot)) return split_mesh(mesh, matrix, numbers_of(slot.runs), slot.box);
  const bool is_all = matrix == nullptr && slot.runs.empty();
  return cut_mesh(mesh, matrix,
                  {.runs = slot.runs,
                   .triangle_count = slot.triangle_count,
                   .owner = {},
                   .box = is_all ? plan.facts[slot.mesh].box : slot.box},
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
