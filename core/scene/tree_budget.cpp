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
    if (trees.geometry_bytes() <= counted) return;
    sum += trees.geometry_bytes() - counted;
    counted = trees.geometry_bytes();
  };
  for (const SceneTrees* trees : scenes_) add(*trees);
  if (more != nullptr) add(*more);
  return sum;
}

std::uint64_t TreeBudget::sum() const {
  std::uint64_t sum = geometry_sum();
  for (const SceneTrees* trees : scenes_) sum += trees->tree_bytes();
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
  return totals;
}

bool TreeBudget::has_room(std::uint64_t bytes) const {
  return limit_ == 0 || used() + bytes <= limit_;
}

Status TreeBudget::admit(SceneTrees& trees) {
  const std::lock_guard hold(mutex_);
  if (limit_ > 0) {
    const std::uint64_t fixed = geometry_sum();
    if (geometry_sum(&trees) + trees.least_tree_bytes() > limit_) {
      return Error{ErrorKind::kOutOfSpace, "SCENE_OVER_BUDGET",
                   "the scene needs " + std::to_string(trees.geometry_bytes()) +
                       " bytes for its geometry and about " +
                       std::to_string(trees.least_tree_bytes()) +
                       " for its largest tree; of the memory budget of " + std::to_string(limit_) +
                       " bytes, " + std::to_string(limit_ - std::min(limit_, fixed)) + " are left",
                   ""};
    }
  }
  scenes_.push_back(&trees);
  return success();
}

void TreeBudget::dismiss(SceneTrees& trees) {
  const std::lock_guard hold(mutex_);
  std::erase(scenes_, &trees);
  add_ever(past_, trees.stats());
}

void TreeBudget::settle() {
  if (limit_ == 0) return;
  const std::lock_guard hold(mutex_);
  while (sum() > limit_) {
    SceneTrees* oldest = nullptr;
    for (SceneTrees* trees : scenes_) {
      if (!trees->can_drop()) continue;
      if (oldest == nullptr || trees->last_use() < oldest->last_use()) oldest = trees;
    }
    if (oldest == nullptr) break;
    try {
      oldest->drop();
    } catch (const std::bad_alloc&) {
      break;
    }
  }
  exceeded_.store(sum() > limit_, std::memory_order_relaxed);
}

}  // namespace sightline
