#pragma once
/// The memory that the scenes of a process may take in total, and which trees are evicted beyond
/// it.

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "core/base/result.h"
#include "core/scene/tree_stats.h"

namespace sightline {

class SceneTrees;

/// Counts positions, indices and trees. May be used from many threads.
class TreeBudget {
 public:
  /// In bytes; 0: no limit.
  explicit TreeBudget(std::uint64_t limit) : limit_(limit) {}

  /// Takes the trees of a scene in. Errors: SCENE_OVER_BUDGET when the scene's geometry and its
  /// largest tree do not fit beside the geometry of the others.
  Status admit(SceneTrees& trees);
  /// Precondition: they were admitted.
  void dismiss(SceneTrees& trees);
  /// While there is too much: drops the trees of the scene that was asked the longest ago, of those
  /// that are not being asked.
  void settle();
  /// Whether so many bytes more would fit.
  bool has_room(std::uint64_t bytes) const;
  /// Whether settle() left too much.
  bool is_exceeded() const { return exceeded_.load(std::memory_order_relaxed); }
  std::uint64_t limit() const { return limit_; }
  std::uint64_t used() const;
  TreeTotals totals() const;

 private:
  std::uint64_t sum() const;
  /// The geometry of all scenes and, if not null, of one more. Shared data counts once.
  std::uint64_t geometry_sum(const SceneTrees* more = nullptr) const;

  const std::uint64_t limit_;
  std::atomic<bool> exceeded_{false};
  mutable std::mutex mutex_;
  std::vector<SceneTrees*> scenes_;
  TreeTotals past_;  ///< what is "ever", of those that were dismissed
};

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
