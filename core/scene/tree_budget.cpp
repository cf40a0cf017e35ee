#include "core/scene/tree_budget.h"

#include <algorithm>
#include <limits>
#include <new>
#include <string>

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

/// Bytes of geometry and its trees, for each byte of geometry (docs/decisions/0033).
constexpr std::uint64_t kWithTrees = 3;

}  // namespace

std::uint64_t TreeBudget::largest_geometry(const std::vector<SceneTrees*>& sharing) {
  std::uint64_t largest = 0;
  for (const SceneTrees* trees : sharing) largest = std::max(largest, trees->held_geometry_bytes());
  return largest;
}

std::uint64_t TreeBudget::geometry_with(const SceneTrees& more) const {
  const auto found = by_geometry_.find(more.geometry());
  const std::uint64_t counted = found == by_geometry_.end() ? 0 : largest_geometry(found->second);
  return geometry_bytes_ + more.held_geometry_bytes() -
         std::min(counted, more.held_geometry_bytes());
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
  totals.geometry_bytes = geometry_bytes_;
  if (overflow_) {
    totals.overflow_bytes = overflow_->bytes();
    totals.evicted_bytes = overflow_->evicted_bytes();
  }
  return totals;
}

std::uint64_t TreeBudget::room() const {
  if (limit_ == 0) return std::numeric_limits<std::uint64_t>::max();
  return limit_ - std::min(limit_, used());
}

Status TreeBudget::admit(SceneTrees& trees) {
  const std::lock_guard hold(mutex_);
  if (limit_ > 0) {
    const std::uint64_t fixed = geometry_bytes_;
    const std::uint64_t tree = overflow_ ? 0 : trees.least_tree_bytes();
    if (geometry_with(trees) + tree > limit_) {
      return Error{ErrorKind::kOutOfSpace, "SCENE_OVER_BUDGET",
                   "the scene needs " + std::to_string(trees.held_geometry_bytes()) +
                       " bytes for its geometry and about " + std::to_string(tree) +
                       " for its largest tree; of the memory budget of " + std::to_string(limit_) +
                       " bytes, " + std::to_string(limit_ - std::min(limit_, fixed)) + " are left",
                   ""};
    }
  }
  const std::uint64_t geometry = geometry_with(trees);
  scenes_.push_back(&trees);
  try {
    by_geometry_[trees.geometry()].push_back(&trees);
  } catch (...) {
    scenes_.pop_back();
    throw;
  }
  geometry_bytes_ = geometry;
  share_out();
  return success();
}

std::shared_ptr<OverflowMemory> TreeBudget::overflow_for(std::uint64_t bytes) const {
  if (limit_ == 0) return nullptr;
  const std::lock_guard hold(mutex_);
  const std::uint64_t least = bytes <= limit_ / kWithTrees ? kWithTrees * bytes : limit_;
  return least < limit_ && geometry_bytes_ <= limit_ - least ? nullptr : overflow_;
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
  overflow_->set_resident_limit(std::max(limit_ / 16, limit_ - std::min(limit_, sum())));
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
  const auto sharing = by_geometry_.find(trees.geometry());
  geometry_bytes_ -= largest_geometry(sharing->second);
  std::erase(sharing->second, &trees);
  geometry_bytes_ += largest_geometry(sharing->second);
  if (sharing->second.empty()) by_geometry_.erase(sharing);
  count_trees(trees.held_tree_bytes(), 0);
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
