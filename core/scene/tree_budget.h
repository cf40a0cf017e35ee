#pragma once
/// TreeBudget: the memory that all scenes of a process may use, and the eviction of trees beyond
/// it.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "core/base/overflow_memory.h"
#include "core/base/result.h"
#include "core/bvh/wide_tree.h"
#include "core/scene/tree_stats.h"

namespace sightline {

class SceneTrees;

/// Counts the bytes of positions, indices and trees of the scenes that joined. Beyond a limit, drops
/// trees of scenes that are not queried, and moves what has no room to OverflowMemory. Of that, the
/// memory may hold what the limit leaves, and at least a 16th of the limit. A scene joins by
/// SceneTrees::join and must leave before it is destroyed; SceneTrees does both. Thread-safe.
class TreeBudget {
 public:
  /// limit     in bytes; 0: no limit
  /// overflow  null: there is none
  explicit TreeBudget(std::uint64_t limit, std::shared_ptr<OverflowMemory> overflow = {})
      : limit_(limit), overflow_(std::move(overflow)) {
    if (overflow_) overflow_->set_resident_limit(limit_);
  }

  /// Adds a scene without its trees (count_trees). Errors: SCENE_OVER_BUDGET if the scene's
  /// geometry and, without overflow memory, its largest tree do not fit beside the geometry of the
  /// other scenes; the scene is then not added.
  Status admit(SceneTrees& trees);
  /// The memory for `bytes` of geometry that have no room, with trees of twice that size, beside the
  /// geometry of all scenes. Null if they have room, or if there is no overflow memory.
  std::shared_ptr<OverflowMemory> overflow_for(std::uint64_t bytes) const;
  /// Returns a tree, copied to the overflow memory unless `bytes` have room, which its scene will
  /// need with this tree. If that gives them room, drops trees of other scenes as settle() does. The
  /// tree remains where it is if the overflow memory is full.
  WideTree placed(WideTree tree, std::uint64_t bytes);
  /// Removes a scene. Precondition: it was admitted.
  void dismiss(SceneTrees& trees);
  /// While the memory exceeds the limit: drops the trees of the least recently queried scene that
  /// no query uses now.
  void settle();
  /// Bytes that the limit leaves; without a limit the largest number.
  std::uint64_t room() const;
  /// True if the memory still exceeded the limit after the last settle().
  bool is_exceeded() const { return exceeded_.load(std::memory_order_relaxed); }
  std::uint64_t limit() const { return limit_; }
  /// Bytes of overflow memory that may be in memory now; 0 without any.
  std::uint64_t overflow_limit() const { return overflow_ ? overflow_->resident_limit() : 0; }
  /// Bytes of all scenes now. Cost: does not grow with their number.
  std::uint64_t used() const;
  /// Counts trees of a scene that joined: `now` bytes instead of `before`. Takes no lock.
  void count_trees(std::uint64_t before, std::uint64_t now) { tree_bytes_ += now - before; }
  /// Statistics of all scenes, removed ones included.
  TreeTotals totals() const;

 private:
  // Preconditions: mutex_ is held.
  std::uint64_t sum() const { return geometry_bytes_ + tree_bytes_; }
  /// The geometry of all scenes and of `more`. Shared geometry counts once, as the largest of those
  /// that share it.
  std::uint64_t geometry_with(const SceneTrees& more) const;
  /// What the geometry of `sharing`, scenes with equal SceneTrees::geometry(), counts.
  static std::uint64_t largest_geometry(const std::vector<SceneTrees*>& sharing);
  /// Sets what the overflow memory may have in memory.
  void share_out() noexcept;
  /// Drops trees of the scenes that were queried least recently until `bytes` more have room. Returns
  /// false if that gives them no room; with `or_none` it then drops no trees.
  bool make_room(std::uint64_t bytes, bool or_none);

  const std::uint64_t limit_;
  const std::shared_ptr<OverflowMemory> overflow_;
  std::atomic<bool> exceeded_{false};
  mutable std::mutex mutex_;
  std::vector<SceneTrees*> scenes_;
  std::unordered_map<const void*, std::vector<SceneTrees*>> by_geometry_;
  std::uint64_t geometry_bytes_ = 0;          ///< of by_geometry_
  std::atomic<std::uint64_t> tree_bytes_{0};  ///< of the trees of all scenes
  TreeTotals past_;                           ///< totals of removed scenes
};

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
