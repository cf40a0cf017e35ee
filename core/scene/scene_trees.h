#pragma once
/// The trees of a scene as a cache: they may be built one by one when rays come near, all at once,
/// read from a file, or dropped. No answer depends on it (law 1).

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/bvh/lazy_layout.h"
#include "core/bvh/scene_tree.h"
#include "core/scene/tree_budget.h"
#include "core/scene/tree_stats.h"

namespace sightline {

/// May be used from many threads. What now() returns never changes: later states are other objects.
class SceneTrees {
 public:
  /// Nothing is built. The plan outlives it.
  SceneTrees(const ScenePlan& plan, std::uint64_t geometry_bytes);
  /// After moved_plan: takes all trees of `before` that did not move; none of them is built again
  /// (LazyLayout::moved). Refers to nothing else of `before`. Throws std::bad_alloc.
  SceneTrees(const ScenePlan& plan, SceneTrees& before, std::span<const std::uint32_t> moved);
  ~SceneTrees();
  SceneTrees(const SceneTrees&) = delete;
  SceneTrees& operator=(const SceneTrees&) = delete;

  /// Held while a query runs, so that its trees are not dropped.
  class Use {
   public:
    explicit Use(SceneTrees& trees);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    SceneTrees& trees_;
  };

  std::shared_ptr<const SceneTree> now() const;

  /// Builds the `wanted` trees of `seen`, a state that now() returned. Each tree is built once,
  /// also when several threads ask. Waits for trees that other threads have begun. A large tree may
  /// be split instead, which leaves some of its parts unbuilt. Returns a state with the new trees
  /// or, if all trees were exchanged meanwhile, the present state. Work that runs on `threads` must
  /// not call it. A build in progress is finished, also after the deadline, unless the deadline's
  /// flag is set. Errors: DEADLINE, CANCELLED. Throws std::bad_alloc and then changes nothing.
  Result<std::shared_ptr<const SceneTree>> build(const std::shared_ptr<const SceneTree>& seen,
                                                 std::span<const std::uint32_t> wanted,
                                                 const Deadline& deadline, ThreadGroup& threads);

  /// How all trees came to be there.
  enum class Origin { kBuilt, kRead };
  /// Puts all trees, in their lasting form, in the place of what is there.
  void complete(SceneTree tree, Origin origin);
  /// Drops all trees: all of them count as unbuilt again. Throws std::bad_alloc.
  void drop();

  /// From now on this scene counts. Errors: SCENE_OVER_BUDGET. Precondition: called once at most.
  Status join(std::shared_ptr<TreeBudget> budget);
  // Numbers for the memory budget.
  std::uint64_t geometry_bytes() const { return geometry_bytes_; }
  /// The address that scenes with shared geometry have in common.
  const void* geometry() const {
    return plan_.meshes.empty() ? this : static_cast<const void*>(plan_.meshes[0].positions.data());
  }
  std::uint64_t tree_bytes() const { return bytes_.load(std::memory_order_relaxed); }
  /// An estimate: of the largest tree that a first ray may need.
  std::uint64_t least_tree_bytes() const { return least_bytes_; }
  /// An estimate: of all of them that were not there when this was made.
  std::uint64_t full_tree_bytes() const { return full_bytes_; }
  bool can_drop() const { return users_.load() == 0 && droppable_.load(); }
  /// On the steady clock; 0: never.
  Deadline::Clock::rep last_use() const { return last_use_.load(); }
  /// Whether some are not there that should be (in their lasting form, unless it was reached before
  /// something moved), and have been of use since they were dropped.
  bool wants_all() const;
  /// Whether the scene was made by moving nodes. Then a background build has only the unbuilt trees
  /// to build.
  bool is_moved() const;

  void count_waiting(std::uint64_t queries) { waited_.fetch_add(queries); }
  void count_rejected_file() { rejects_.fetch_add(1); }
  TreeStats stats() const;
  /// The number of trees that were built. Every query reads it.
  std::uint64_t trees_built() const;
  const ScenePlan& plan() const { return plan_; }

 private:
  enum class SlotState : std::uint8_t { kUnbuilt, kBuilding, kDone };
  /// The trees that a thread has undertaken to build.
  struct Claim {
    std::uint32_t number = 0;
    TreeSlot slot;
    std::shared_ptr<const WideTree> tree;  ///< when built
    std::vector<MeshPart> parts;           ///< when cut
  };

  /// Precondition for this: mutex_ is held.
  void show(std::shared_ptr<const SceneTree> tree, bool droppable);
  std::shared_ptr<TreeBudget> budget() const;
  bool is_present(const SceneTree& seen) const { return layout_ && seen.unbuilt == now_->unbuilt; }
  std::vector<Claim> claim(std::span<const std::uint32_t> wanted);
  void make(Claim& claim, const CancelFlag* cancel) const;
  void publish(std::vector<Claim>& claims);
  void give_back(const std::vector<Claim>& claims);
  void estimate();
  bool wait(const SceneTree& seen, std::span<const std::uint32_t> wanted, const Deadline& deadline);

  const ScenePlan& plan_;
  const std::uint64_t geometry_bytes_;
  std::uint64_t least_bytes_ = 0;
  std::uint64_t full_bytes_ = 0;
  std::atomic<std::uint64_t> waited_{0};
  std::atomic<std::uint64_t> rejects_{0};
  std::atomic<std::uint64_t> bytes_{0};
  std::atomic<bool> droppable_{false};
  std::atomic<int> users_{0};
  std::atomic<Deadline::Clock::rep> last_use_{0};
  std::atomic<Deadline::Clock::rep> last_drop_{0};

  mutable std::mutex mutex_;  ///< for what follows; not held while a tree is built
  std::condition_variable changed_;
  std::shared_ptr<const SceneTree> now_;
  std::optional<LazyLayout> layout_;  ///< none while trees have their lasting form
  bool moved_ = false;                ///< is a lasting form but for what has moved since
  std::vector<SlotState> states_;
  std::vector<bool> mesh_built_;
  TreeStats stats_;
  std::shared_ptr<TreeBudget> budget_;
};

}  // namespace sightline
