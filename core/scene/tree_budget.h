#pragma once
/// TreeBudget: the memory that all scenes of a process may use, and the eviction of trees beyond
/// it.

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "core/base/result.h"
#include "core/scene/tree_stats.h"

namespace sightline {

class SceneTrees;

/// Counts the bytes of positions, indices and trees of the scenes that joined, and drops trees
/// beyond a limit. A scene joins by SceneTrees::join and must leave before it is destroyed;
/// SceneTrees does both. Thread-safe.
class TreeBudget {
 public:
  /// `limit` in bytes; 0: no limit.
  explicit TreeBudget(std::uint64_t limit) : limit_(limit) {}

  /// Adds a scene. Errors: SCENE_OVER_BUDGET if the scene's geometry and its largest tree do not
  /// fit beside the geometry of the other scenes; the scene is then not added.
  Status admit(SceneTrees& trees);
  /// Removes a scene. Precondition: it was admitted.
  void dismiss(SceneTrees& trees);
  /// While the memory exceeds the limit: drops the trees of the least recently queried scene that
  /// no query uses now.
  void settle();
  /// True if `bytes` more would not exceed the limit.
  bool has_room(std::uint64_t bytes) const;
  /// True if the memory still exceeded the limit after the last settle().
  bool is_exceeded() const { return exceeded_.load(std::memory_order_relaxed); }
  std::uint64_t limit() const { return limit_; }
  /// Bytes of all scenes now.
  std::uint64_t used() const;
  /// Statistics of all scenes, removed ones included.
  TreeTotals totals() const;

 private:
  std::uint64_t sum() const;
  /// Bytes of the geometry of all scenes and, if not null, of `more`. Shared geometry counts
  /// once, as the largest of those that share it.
  std::uint64_t geometry_sum(const SceneTrees* more = nullptr) const;

  const std::uint64_t limit_;
  std::atomic<bool> exceeded_{false};
  mutable std::mutex mutex_;
  std::vector<SceneTrees*> scenes_;
  TreeTotals past_;  ///< totals of removed scenes
};

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
