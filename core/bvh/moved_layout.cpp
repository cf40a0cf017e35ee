/// How the trees of a scene outlive a move of some of its placements.

#include <algorithm>

#include "core/bvh/lazy_layout.h"
#include "core/bvh/placing.h"
#include "core/bvh/prune.h"

namespace sightline {

namespace {

constexpr std::uint32_t kNoTree = 0xffffffffu;

/// Carries trees over, each under a new number when something first enters it.
class CarriedTrees {
 public:
  CarriedTrees(const SceneTree& from, const std::vector<TreeSlot>& from_slots, SceneTree& to,
               std::vector<TreeSlot>& to_slots)
      : from_(from),
        from_slots_(from_slots),
        to_(to),
        to_slots_(to_slots),
        number_(from.trees.size(), kNoTree) {}

  /// What enters it now enters the tree that is returned.
  std::uint32_t carry(std::uint32_t tree) {
    if (number_[tree] == kNoTree) {
      number_[tree] = add(from_.trees[tree], from_slots_[tree]);
      to_slots_.back().entries = 0;
    }
    ++to_slots_[number_[tree]].entries;
    return number_[tree];
  }
  std::uint32_t add(std::shared_ptr<const WideTree> tree, TreeSlot slot) {
    to_.trees.push_back(std::move(tree));
    to_slots_.push_back(std::move(slot));
    return static_cast<std::uint32_t>(to_.trees.size() - 1);
  }

 private:
  const SceneTree& from_;
  const std::vector<TreeSlot>& from_slots_;
  SceneTree& to_;
  std::vector<TreeSlot>& to_slots_;
  std::vector<std::uint32_t> number_;
};

/// Slots of trees that are all there: nobody will build them.
std::vector<TreeSlot> slots_of(const ScenePlan& plan, const SceneTree& tree) {
  std::vector<TreeSlot> slots(tree.trees.size());
  for (std::uint32_t i = 0; i < tree.entries; ++i) {
    const Placement& placement = tree.placements[i];
    TreeSlot& slot = slots[placement.tree];
    slot.mesh = plan.placements[placement.instance].mesh;
    slot.placement = has_own_tree(placement) ? placement.instance : kOwnSpace;
    slot.triangle_count = plan.meshes[slot.mesh].triangle_count();
    slot.whole = true;
  }
  return slots;
}

/// The entries of a state, read one after the other.
struct Entries {
  const ScenePlan& plan;
  const SceneTree& tree;
  const std::vector<Box3d>* boxes;  ///< null: those of the plan

  Box3d box(std::uint32_t i) const {
    return boxes != nullptr ? (*boxes)[i] : plan.placed[tree.placements[i].instance];
  }
};

}  // namespace

LazyLayout::WithState LazyLayout::moved(const ScenePlan& plan, const ScenePlan& plan_before,
                                        const LazyLayout* before, const SceneTree& tree,
                                        std::span<const std::uint32_t> moved,
                                        std::span<const std::uint32_t> fresh) {
  WithState next{LazyLayout(plan), {}};
  LazyLayout& layout = next.layout;
  const std::vector<TreeSlot> slots =
      before != nullptr ? before->slots_ : slots_of(plan_before, tree);
  CarriedTrees trees(tree, slots, next.tree, layout.slots_);
  const Entries entries{plan, tree, before != nullptr ? &before->boxes_ : nullptr};
  std::vector<bool> is_moved(plan.placements.size());
  for (const std::uint32_t number : moved) is_moved[number] = true;
  std::vector<bool> is_fresh(plan.meshes.size());
  for (const std::uint32_t number : fresh) is_fresh[number] = true;

  std::vector<Placement> placements;
  placements.reserve(std::max(tree.placements.size(), plan.placements.size()));
  layout.boxes_.reserve(placements.capacity());
  const auto enter = [&](const Placement& placement, const Box3d& box) {
    placements.push_back(placement);
    layout.boxes_.push_back(box);
  };
  std::vector<std::uint32_t> own_space(plan.meshes.size(), kNoTree);  // by the numbers of `tree`
  // The last entry shares its tree with the placements behind the entries.
  const bool shares = tree.placements.size() > tree.entries;
  for (std::uint32_t i = 0; i < tree.entries - (shares ? 1 : 0); ++i) {
    Placement placement = tree.placements[i];
    const TreeSlot& slot = slots[placement.tree];
    if (slot.placement == kOwnSpace && slot.runs.empty() && !has_own_tree(placement) &&
        !plan.is_cut(slot.mesh) && !is_fresh[slot.mesh])
      own_space[slot.mesh] = placement.tree;
    if (is_moved[placement.instance]) continue;
    placement.tree = trees.carry(placement.tree);
    enter(placement, entries.box(i));
  }

  next.tree.unbuilt = tree.unbuilt ? tree.unbuilt : make_empty_tree();
  std::vector<std::uint32_t> unbuilt(plan.meshes.size(), kNoTree);
  for (const std::uint32_t i : moved) {
    if (plan.placed[i].empty()) continue;
    const std::uint32_t mesh = plan.placements[i].mesh;
    Placement placement = place_alone(plan, i, true);
    const bool own = has_own_tree(placement);
    if (!own && own_space[mesh] != kNoTree) {
      placement.tree = trees.carry(own_space[mesh]);
    } else if (!own && unbuilt[mesh] != kNoTree) {
      placement.tree = unbuilt[mesh];
      ++layout.slots_[placement.tree].entries;
    } else {
      placement.tree =
          trees.add(next.tree.unbuilt, {.mesh = mesh,
                                        .placement = own ? i : kOwnSpace,
                                        .triangle_count = plan.meshes[mesh].triangle_count(),
                                        .entries = 1});
      if (!own) unbuilt[mesh] = placement.tree;
    }
    TreeSlot& slot = layout.slots_[placement.tree];
    slot.whole = slot.whole || !own;
    slot.box = plan.placed[i];
    enter(placement, plan.placed[i]);
  }
  if (shares) {
    layout.carry_shared(tree.placements.subspan(tree.entries - 1), is_moved, tree, next.tree,
                        placements);
  }

  layout.place(std::move(placements), next.tree);
  std::uint32_t deepest = next.tree.unbuilt->depth;
  for (const auto& each : next.tree.trees) {
    deepest = std::max(deepest, each->depth);
    if (each == next.tree.unbuilt) ++next.tree.unbuilt_count;
  }
  next.tree.depth = next.tree.top.depth + deepest;
  return next;
}

/// `shared` are the last entry of a state and those that share its tree; they are added to
/// `placements`.
void LazyLayout::carry_shared(std::span<const Placement> shared, const std::vector<bool>& is_moved,
                              const SceneTree& from, SceneTree& to,
                              std::vector<Placement>& placements) {
  const auto is_gone = [&](const Placement& placement) {
    return placement.instance == kGone || is_moved[placement.instance];
  };
  if (std::all_of(shared.begin(), shared.end(), is_gone)) return;
  const bool stays = std::none_of(shared.begin(), shared.end(), [&](const Placement& placement) {
    return placement.instance != kGone && is_moved[placement.instance];
  });
  auto tree = from.trees[shared[0].tree];
  if (!stays) {
    WideTree left = without_placements(*tree, [&](std::uint32_t k) { return is_gone(shared[k]); });
    tree = left.root == ChildRef::kEmpty ? make_empty_tree()
                                         : std::make_shared<const WideTree>(std::move(left));
  }
  Box3d box;
  std::uint32_t mesh = 0;
  const auto number = static_cast<std::uint32_t>(to.trees.size());
  for (Placement placement : shared) {
    if (is_gone(placement)) {
      placement.instance = kGone;
    } else {
      if (box.empty()) mesh = plan_.placements[placement.instance].mesh;
      box.include(plan_.placed[placement.instance]);
    }
    placement.tree = number;
    placements.push_back(placement);
  }
  to.trees.push_back(std::move(tree));
  slots_.push_back({.mesh = mesh, .entries = 1, .whole = true});
  boxes_.push_back(box);
}

}  // namespace sightline
