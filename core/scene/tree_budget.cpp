#include "core/scene/tree_budget.h"

#include <algorithm>
#include <new>
#include <string>
#include <unordered_map>

#include "core/scene/scene_trees.h"

namespace sightline {
namespace {

void add_ever(TreeTotals& totals, const TreeStats& stats) {
  totals.trees_built += stats.trees_built;
  totals.full_builds += stats.full_builds;
  totals.evictions += stats.evictions;
  totals.cache_hits += stats.cache_hits;
  totals.cache_rejects += stats.cache_rejects;
  totals.queries_waited += stats.queries_waited;
}

}  // namespace

/// Precondition for these: mutex_ is held.
std::uint64_t TreeBudget::geometry_sum(const SceneTrees* more) const {
  std::unordered_map<const void*, std::uint64_t> seen;
  std::uint64_t sum = 0;
  const auto add = [&](const SceneTrees& trees) {
    std::uint64_t& counted = seen[trees.geometry()];
    if (trees.held_geometry_bytes() <= counted) return;
    sum += trees.held_geometry_bytes() - counted;
    counted = trees.held_geometry_bytes();
  };
  for (const SceneTrees* trees : scenes_) add(*trees);
  if (more != nullptr) add(*more);
  return sum;
}

std::uint64_t TreeBudget::sum() const {
  std::uint64_t sum = geometry_sum();
  for (const SceneTrees* trees : scenes_) sum += trees->held_tree_bytes();
  return sum;
}

std::uint64_t TreeBudget::used() const {
  const std::lock_guard hold(mutex_);
  return sum();
}

TreeTotals TreeBudget::totals() const {
  const std::lock_guard hold(mutex_);
  TreeTotals totals = past_;
  for (const SceneTrees* trees : scenes_) {
    add_ever(totals, trees->stats());
    totals.tree_bytes += trees->tree_bytes();
  }
  totals.geometry_bytes = geometry_sum();
  if (overflow_) {
    totals.overflow_bytes = overflow_->bytes();
    totals.evicted_bytes = overflow_->evicted_bytes();
  }
  return totals;
}

bool TreeBudget::has_room(std::uint64_t bytes) const {
  const std::uint64_t now = used();
  return limit_ == 0 || (bytes <= limit_ && now <= limit_ - bytes);
}

Status TreeBudget::admit(SceneTrees& trees) {
  const std::lock_guard hold(mutex_);
  if (limit_ > 0) {
    const std::uint64_t fixed = geometry_sum();
    const std::uint64_t tree = overflow_ ? 0 : trees.least_tree_bytes();
    if (geometry_sum(&trees) + tree > limit_) {
      return Error{ErrorKind::kOutOfSpace, "SCENE_OVER_BUDGET",
                   "the scene needs " + std::to_string(trees.held_geometry_bytes()) +
                       " bytes for its geometry and about " + std::to_string(tree) +
                       " for its largest tree; of the memory budget of " + std::to_string(limit_) +
                       " bytes, " + std::to_string(limit_ - std::min(limit_, fixed)) + " are left",
                   ""};
    }
  }
  scenes_.push_back(&trees);
  share_out();
  return success();
}

std::shared_ptr<OverflowMemory> TreeBudget::overflow_for(std::uint64_t bytes) const {
  if (limit_ == 0) return nullptr;
  const std::lock_guard hold(mutex_);
  const std::uint64_t geometry = geometry_sum();
  return bytes <= limit_ && geometry <= limit_ - bytes ? nullptr : overflow_;
}

WideTree TreeBudget::placed(WideTree tree, std::uint64_t bytes) {
  const std::size_t size = tree.arena.used();
  if (limit_ == 0 || overflow_ == nullptr || size == 0) return tree;
  {
    const std::lock_guard hold(mutex_);
    if (make_room(bytes, true)) return tree;
  }
  const auto memory = overflow_->take(size);
  if (!memory) return tree;
  std::copy_n(tree.arena.at(0), size, memory.get());
  tree.arena = Arena(memory.get(), size, memory);
  tree.in_overflow = true;
  return tree;
}

void TreeBudget::share_out() noexcept {
  if (!overflow_) return;
  try {
    overflow_->set_resident_limit(std::max(limit_ / 16, limit_ - std::min(limit_, sum())));
  } catch (const std::bad_alloc&) {
    // The limit of the last time is nearly right.
  }
}

bool TreeBudget::make_room(std::uint64_t bytes, bool or_none) {
  const auto has_room = [&](std::uint64_t now) { return bytes <= limit_ && now <= limit_ - bytes; };
  if (or_none) {
    std::uint64_t fixed = sum();
    for (const SceneTrees* trees : scenes_) fixed -= std::min(fixed, trees->droppable_bytes());
    if (!has_room(fixed)) return false;
  }
  while (!has_room(sum())) {
    SceneTrees* oldest = nullptr;
    for (SceneTrees* trees : scenes_) {
      if (trees->droppable_bytes() == 0) continue;
      if (oldest == nullptr || trees->last_use() < oldest->last_use()) oldest = trees;
    }
    if (oldest == nullptr) return false;
    try {
      oldest->drop();
    } catch (const std::bad_alloc&) {
      return false;
    }
  }
  return true;
}

void TreeBudget::dismiss(SceneTrees& trees) {
  const std::lock_guard hold(mutex_);
  std::erase(scenes_, &trees);
  add_ever(past_, trees.stats());
  share_out();
}

void TreeBudget::settle() {
  if (limit_ == 0) return;
  const std::lock_guard hold(mutex_);
  make_room(0, false);
  exceeded_.store(sum() > limit_, std::memory_order_relaxed);
  share_out();
}

}  // namespace sightline
