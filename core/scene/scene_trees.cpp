#include "core/scene/scene_trees.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/thread_group.h"

namespace sightline {

namespace {

/// Nodes and leaves of what a builder makes, for each triangle: where triangles share no vertices,
/// and where more than four meet at a vertex (docs/decisions/0033).
constexpr std::uint64_t kMostBytes = 56, kSharedBytes = 38;

std::uint64_t bytes_per_triangle(const MeshView& mesh) {
  return mesh.indices.size() > 4 * mesh.positions.size() ? kSharedBytes : kMostBytes;
}

}  // namespace

SceneTrees::Use::Use(SceneTrees& trees) : trees_(trees) {
  trees_.users_.fetch_add(1);
  trees_.last_use_.store(Deadline::Clock::now().time_since_epoch().count());
}

SceneTrees::Use::~Use() {
  if (trees_.users_.fetch_sub(1) > 1) return;
  if (const auto budget = trees_.budget(); budget && budget->is_exceeded()) budget->settle();
}

SceneTrees::SceneTrees(const ScenePlan& plan, const GeometryBytes& geometry_bytes)
    : plan_(plan), geometry_bytes_(geometry_bytes), geometry_(std::make_shared<const char>()) {
  stats_.meshes_total = plan.distinct;
  stats_.geometry_bytes = geometry_bytes.all;
  drop();
  last_drop_.store(0);
  stats_.evictions = 0;
  estimate();
}

SceneTrees::SceneTrees(const ScenePlan& plan, const GeometryBytes& geometry_bytes,
                       SceneTrees& before, std::span<const std::uint32_t> moved,
                       std::span<const std::uint32_t> fresh)
    : plan_(plan), geometry_bytes_(geometry_bytes), geometry_(before.geometry_) {
  std::shared_ptr<const SceneTree> tree;
  std::optional<LazyLayout> layout;
  {
    const std::lock_guard hold(before.mutex_);
    tree = before.now_;
    if (before.layout_) layout.emplace(*before.layout_);
    moved_ = !layout || before.moved_;
  }
  last_use_.store(before.last_use_.load());
  lasting_bytes_.store(before.lasting_bytes_.load());
  auto next =
      LazyLayout::moved(plan, before.plan_, layout ? &*layout : nullptr, *tree, moved, fresh);
  layout_.emplace(std::move(next.layout));
  mesh_built_.assign(plan.meshes.size(), false);
  for (const TreeSlot& slot : layout_->slots()) {
    const auto number = states_.size();
    const bool is_there = !next.tree.is_unbuilt(static_cast<std::uint32_t>(number));
    states_.push_back(is_there ? SlotState::kDone : SlotState::kUnbuilt);
    if (!is_there) continue;
    ++stats_.trees_kept;
    mesh_built_[slot.mesh] = true;
  }
  for (const Placement& placement : next.tree.placements.subspan(next.tree.entries)) {
    if (placement.instance < plan.placements.size())
      mesh_built_[plan.placements[placement.instance].mesh] = true;
  }
  stats_.meshes_total = plan.distinct;
  stats_.geometry_bytes = geometry_bytes.all;
  show(std::make_shared<const SceneTree>(std::move(next.tree)), true);
  estimate();
}

void SceneTrees::estimate() {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const TreeSlot& slot = layout_->slots()[i];
    const std::uint64_t bytes_each = bytes_per_triangle(plan_.meshes[slot.mesh]);
    full_bytes_ += slot.triangle_count * bytes_each;
    if (states_[i] != SlotState::kUnbuilt) continue;
    const std::uint32_t part = slot.whole ? plan_.tree_triangles : 32 * kPartTriangles;
    const std::uint64_t first = std::min(slot.triangle_count, part);
    least_bytes_ = std::max(least_bytes_, first * bytes_each);
  }
  least_bytes_ += bytes_.load();
}

SceneTrees::~SceneTrees() {
  if (budget_) budget_->dismiss(*this);
}

Status SceneTrees::join(std::shared_ptr<TreeBudget> budget) {
  if (Status status = budget->admit(*this); !status) return status;
  const std::lock_guard hold(mutex_);
  budget->count_trees(0, held_tree_bytes());
  budget_ = std::move(budget);
  return success();
}

std::shared_ptr<TreeBudget> SceneTrees::budget() const {
  const std::lock_guard hold(mutex_);
  return budget_;
}

std::uint64_t SceneTrees::overflow_limit() const {
  const auto all_scenes = budget();
  return all_scenes ? all_scenes->overflow_limit() : 0;
}

std::shared_ptr<const SceneTree> SceneTrees::now() const {
  const std::lock_guard hold(mutex_);
  return now_;
}

void SceneTrees::show(std::shared_ptr<const SceneTree> tree, bool droppable) {
  now_ = std::move(tree);
  const std::uint64_t bytes = now_->bytes(), held = bytes - now_->overflow_bytes();
  bytes_.store(bytes, std::memory_order_relaxed);
  if (budget_) budget_->count_trees(held_bytes_.load(), held);
  held_bytes_.store(held, std::memory_order_relaxed);
  droppable_.store(droppable ? held - now_->top.arena.used() : 0);
}

void SceneTrees::drop() {
  auto [layout, tree] = LazyLayout::unbuilt(plan_);
  auto none = std::make_shared<const SceneTree>(std::move(tree));
  const std::lock_guard hold(mutex_);
  states_.assign(layout.slots().size(), SlotState::kUnbuilt);
  mesh_built_.assign(plan_.meshes.size(), false);
  layout_.emplace(std::move(layout));
  moved_ = false;
  show(std::move(none), false);
  ++stats_.evictions;
  last_drop_.store(Deadline::Clock::now().time_since_epoch().count());
  changed_.notify_all();
}

std::uint64_t SceneTrees::lasting_build_bytes() const {
  // Those that exist are replaced one after the other, and freed.
  const std::uint64_t largest =
      std::min<std::uint64_t>(full_bytes_, plan_.tree_triangles * kMostBytes);
  return std::max(
      {largest, lasting_bytes_.load(), full_bytes_ - std::min(full_bytes_, held_tree_bytes())});
}

bool SceneTrees::wants_all() const {
  const std::lock_guard hold(mutex_);
  return layout_ && (!moved_ || now_->unbuilt_count > 0) && last_use_.load() >= last_drop_.load();
}

bool SceneTrees::is_moved() const {
  const std::lock_guard hold(mutex_);
  return moved_;
}

void SceneTrees::replace(std::span<const FinishedTree> finished) {
  std::shared_ptr<const SceneTree> before;  // its trees are freed without the lock
  {
    const std::lock_guard hold(mutex_);
    if (!layout_) return;
    LazyLayout layout = *layout_;
    auto state = std::make_shared<const SceneTree>(layout.replace(finished, *now_));
    states_.resize(state->trees.size(), SlotState::kDone);
    for (std::uint32_t i = 0; i < states_.size(); ++i) {
      if (state->is_unbuilt(i)) continue;
      states_[i] = SlotState::kDone;
      if (layout.slots()[i].entries > 0) mesh_built_[layout.slots()[i].mesh] = true;
    }
    layout_.emplace(std::move(layout));
    before = now_;
    show(std::move(state), true);
    changed_.notify_all();
  }
  before.reset();
  if (const auto all_scenes = budget()) all_scenes->settle();
}

void SceneTrees::complete(SceneTree tree, Origin origin) {
  auto all = std::make_shared<const SceneTree>(std::move(tree));
  {
    const std::lock_guard hold(mutex_);
    lasting_bytes_.store(all->bytes());
    show(std::move(all), true);
    layout_.reset();
    moved_ = false;
    states_ = {};
    ++(origin == Origin::kBuilt ? stats_.full_builds : stats_.cache_hits);
    changed_.notify_all();
  }
  if (const auto all_scenes = budget()) all_scenes->settle();
}

TreeStats SceneTrees::stats() const {
  const std::lock_guard hold(mutex_);
  TreeStats stats = stats_;
  stats.queries_waited = waited_.load();
  stats.cache_rejects = rejects_.load();
  stats.complete = now_->complete();
  stats.tree_bytes = tree_bytes();
  stats.meshes_built =
      layout_ ? static_cast<std::uint64_t>(std::count(mesh_built_.begin(), mesh_built_.end(), true))
              : stats.meshes_total;
  return stats;
}

std::uint64_t SceneTrees::trees_built() const {
  const std::lock_guard hold(mutex_);
  return stats_.trees_built;
}

/// Precondition for these: mutex_ is held, and `wanted` are slots of the present layout.
std::vector<SceneTrees::Claim> SceneTrees::claim(std::span<const std::uint32_t> wanted) {
  std::vector<Claim> claims;
  for (const std::uint32_t number : wanted) {
    if (states_[number] != SlotState::kUnbuilt) continue;
    claims.push_back({number, layout_->slots()[number], {}, {}});
  }
  for (const Claim& claim : claims) states_[claim.number] = SlotState::kBuilding;
  return claims;
}

void SceneTrees::publish(std::vector<Claim>& claims) {
  std::erase_if(claims, [&](const Claim& claim) {  // replaced meanwhile
    return states_[claim.number] != SlotState::kBuilding;
  });
  if (claims.empty()) return;
  // Everything that may fail comes before everything that is seen.
  SceneTree next = share(*now_);
  std::optional<LazyLayout> layout;
  for (Claim& claim : claims) {
    if (claim.tree) {
      next.trees[claim.number] = claim.tree;
      next.depth = std::max(next.depth, next.top.depth + claim.tree->depth);
      --next.unbuilt_count;
      continue;
    }
    if (!layout) layout.emplace(*layout_);
    next = layout->split(claim.number, std::move(claim.parts), next);
  }
  auto state = std::make_shared<const SceneTree>(std::move(next));
  states_.resize(state->trees.size(), SlotState::kUnbuilt);
  if (layout) layout_.emplace(std::move(*layout));
  show(std::move(state), true);
  for (const Claim& claim : claims) {
    states_[claim.number] = SlotState::kDone;
    ++(claim.tree ? stats_.trees_built : stats_.meshes_split);
    if (claim.tree) mesh_built_[claim.slot.mesh] = true;
  }
}

void SceneTrees::give_back(const std::vector<Claim>& claims) {
  for (const Claim& claim : claims) {
    if (states_[claim.number] == SlotState::kBuilding) states_[claim.number] = SlotState::kUnbuilt;
  }
}

void SceneTrees::make(Claim& claim, const CancelFlag* cancel, TreeBudget* budget) const {
  if (is_cancelled(cancel)) return;
  if (can_split(plan_, claim.slot)) {
    claim.parts = split_slot(plan_, claim.slot);
    return;
  }
  WideTree tree = build_slot(plan_, claim.slot, TreeQuality::kFast, cancel);
  if (budget != nullptr) {
    // A scene whose trees fit only in part has all of them there: in what the budget has left, any of
    // them may then be in memory.
    const std::uint64_t to_come = full_bytes_ - std::min(full_bytes_, tree_bytes());
    const std::uint64_t room = std::max<std::uint64_t>(to_come, tree.arena.used());
    tree = budget->placed(std::move(tree), room);
  }
  claim.tree = std::make_shared<const WideTree>(std::move(tree));
  if (claim.tree->root == ChildRef::kEmpty) claim.tree = make_empty_tree();
}

/// False when the time is up.
bool SceneTrees::wait(const SceneTree& seen, std::span<const std::uint32_t> wanted,
                      const Deadline& deadline) {
  std::unique_lock hold(mutex_);
  const auto is_there = [&] {
    return !is_present(seen) ||
           std::none_of(wanted.begin(), wanted.end(), [&](std::uint32_t number) {
             return states_[number] == SlotState::kBuilding;
           });
  };
  while (!is_there()) {
    if (deadline.passed()) return false;
    // A flag wakes nobody: check again soon.
    const auto soon = Deadline::Clock::now() + std::chrono::milliseconds(20);
    changed_.wait_until(hold, std::min(deadline.at, soon));
  }
  return true;
}

Result<std::shared_ptr<const SceneTree>> SceneTrees::build(
    const std::shared_ptr<const SceneTree>& seen, std::span<const std::uint32_t> wanted,
    const Deadline& deadline, ThreadGroup& threads) {
  std::vector<Claim> claims;
  const auto all_scenes = budget();
  {
    const std::lock_guard hold(mutex_);
    if (!is_present(*seen)) return now_;
    claims = claim(wanted);
  }
  try {
    threads.execute([&] {
      parallel_for(claims.size(),
                   [&](std::size_t i) { make(claims[i], deadline.flag, all_scenes.get()); });
    });
    const std::lock_guard hold(mutex_);
    if (!is_present(*seen)) return now_;
    if (is_cancelled(deadline.flag)) {
      give_back(claims);
      changed_.notify_all();
      return out_of_time(deadline);
    }
    if (!claims.empty()) publish(claims);
  } catch (...) {
    const std::lock_guard hold(mutex_);
    if (is_present(*seen)) give_back(claims);
    changed_.notify_all();
    throw;
  }
  changed_.notify_all();
  if (all_scenes) all_scenes->settle();
  if (!wait(*seen, wanted, deadline)) return out_of_time(deadline);
  return now();
}

}  // namespace sightline
