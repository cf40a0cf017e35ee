#pragma once
/// SceneTrees: the trees of a scene as a cache. Trees may be built one by one on demand, built all
/// at once, read from a file, or dropped. No answer depends on it (law 1).

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/bvh/lazy_layout.h"
#include "core/bvh/scene_tree.h"
#include "core/scene/tree_budget.h"
#include "core/scene/tree_stats.h"

namespace sightline {

class ThreadGroup;

/// The trees of one scene. A query takes a Use, reads now(), and calls build() for the unbuilt
/// trees that it needs. A state that now() returned never changes; a change makes a new state.
/// Thread-safe.
///
/// Trees have two forms: built one by one by the LazyLayout of the scene, or all at once by
/// build_scene_tree, which is called the lasting form.
class SceneTrees {
 public:
  /// geometry_bytes and overflow_bytes of a scene.
  struct GeometryBytes {
    std::uint64_t all = 0, overflow = 0;
  };
  /// Starts with no tree built. The plan must outlive the object.
  SceneTrees(const ScenePlan& plan, const GeometryBytes& geometry_bytes);
  /// For a scene with moved placements and meshes of other content (moved_plan): uses all trees of
  /// `before` that did not change; none of them is built again (LazyLayout::moved). Counts its
  /// geometry as shared with `before`, but does not refer to it afterwards. Throws std::bad_alloc.
  SceneTrees(const ScenePlan& plan, const GeometryBytes& geometry_bytes, SceneTrees& before,
             std::span<const std::uint32_t> moved, std::span<const std::uint32_t> fresh);
  ~SceneTrees();
  SceneTrees(const SceneTrees&) = delete;
  SceneTrees& operator=(const SceneTrees&) = delete;

  /// A query holds a Use while it runs, so that its trees are not dropped. `trees` must outlive it.
  class Use {
   public:
    explicit Use(SceneTrees& trees);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    SceneTrees& trees_;
  };

  /// The present state.
  std::shared_ptr<const SceneTree> now() const;

  /// Builds the trees `wanted` (indices in SceneTree::trees) of `seen`, a state that now()
  /// returned. Each tree is built once, even if several threads request it; the call waits for
  /// trees that other threads are building. A large tree may be split instead, which leaves some of
  /// its parts unbuilt. Returns a state with the new trees or, if all trees were replaced
  /// meanwhile, the present state. Must not be called from work that runs on `threads`. A build in
  /// progress is finished even after the deadline, unless the deadline's flag is set. Errors:
  /// DEADLINE, CANCELLED. Throws std::bad_alloc, and then changes nothing.
  Result<std::shared_ptr<const SceneTree>> build(const std::shared_ptr<const SceneTree>& seen,
                                                 std::span<const std::uint32_t> wanted,
                                                 const Deadline& deadline, ThreadGroup& threads);

  /// Replaces trees by finished ones of the lasting form before the others are finished, so that
  /// both forms of all trees are not in memory at once (LazyLayout::replace). Throws
  /// std::bad_alloc, and then changes nothing.
  void replace(std::span<const FinishedTree> finished);
  /// How all trees of a scene were made: built, or read from a file.
  enum class Origin { kBuilt, kRead };
  /// Replaces the present trees by all trees of the scene, built at once as they are stored.
  void complete(SceneTree tree, Origin origin);
  /// Drops all trees: they are unbuilt until a query needs them. Publishes a new list of trees, so
  /// it throws std::bad_alloc; then the trees stay. Running queries hold the trees that they use.
  void drop();

  /// Adds the scene to a memory budget. Errors: SCENE_OVER_BUDGET. Precondition: called at most
  /// once.
  Status join(std::shared_ptr<TreeBudget> budget);
  // Figures for the memory budget, in bytes; `held`: without what is in OverflowMemory.
  std::uint64_t held_geometry_bytes() const {
    return geometry_bytes_.all - geometry_bytes_.overflow;
  }
  /// Equal for scenes that share their geometry.
  const void* geometry() const { return geometry_.get(); }
  /// Bytes of the trees that exist now.
  std::uint64_t tree_bytes() const { return bytes_.load(std::memory_order_relaxed); }
  std::uint64_t held_tree_bytes() const { return held_bytes_.load(std::memory_order_relaxed); }
  /// Bytes of OverflowMemory that the budget has room for now; 0 without a budget.
  std::uint64_t overflow_limit() const;
  /// Estimated bytes of the largest tree that a first ray may need.
  std::uint64_t least_tree_bytes() const { return least_bytes_; }
  /// Estimated bytes of all trees that are built one by one.
  std::uint64_t full_tree_bytes() const { return full_bytes_; }
  /// Estimated bytes that a build of the lasting form takes beyond the trees that exist. At least
  /// what it took before it was dropped, for this scene or its revision before a node moved.
  std::uint64_t lasting_build_bytes() const;
  /// Bytes that drop() would free now: none while a query uses the trees.
  std::uint64_t droppable_bytes() const { return users_.load() == 0 ? droppable_.load() : 0; }
  /// Time of the last query on the steady clock; 0: none yet.
  Deadline::Clock::rep last_use() const { return last_use_.load(); }
  /// True if a background build should run: trees are unbuilt or not in the lasting form, and the
  /// scene was queried since its trees were last dropped. Trees that were in the lasting form
  /// before a node moved count as lasting.
  bool wants_all() const;
  /// True if the trees were in the lasting form before nodes moved, and were not dropped since.
  /// Then a background build builds only the unbuilt trees.
  bool is_moved() const;

  /// Adds to TreeStats::queries_waited.
  void count_waiting(std::uint64_t queries) { waited_.fetch_add(queries); }
  /// Adds one to TreeStats::cache_rejects.
  void count_rejected_file() { rejects_.fetch_add(1); }
  /// The present statistics.
  TreeStats stats() const;
  /// The number of trees that were built so far. Every query reads it.
  std::uint64_t trees_built() const;
  const ScenePlan& plan() const { return plan_; }

 private:
  enum class SlotState : std::uint8_t { kUnbuilt, kBuilding, kDone };
  /// A tree that a thread builds.
  struct Claim {
    std::uint32_t number = 0;
    TreeSlot slot;
    std::shared_ptr<const WideTree> tree;  ///< the tree, when it is built
    std::vector<MeshPart> parts;           ///< the parts instead, when the tree is split
  };

  /// Makes a state the present one, and counts its bytes. Precondition: mutex_ is held.
  void show(std::shared_ptr<const SceneTree> tree, bool droppable);
  std::shared_ptr<TreeBudget> budget() const;
  bool is_present(const SceneTree& seen) const { return layout_ && seen.unbuilt == now_->unbuilt; }
  std::vector<Claim> claim(std::span<const std::uint32_t> wanted);
  void make(Claim& claim, const CancelFlag* cancel, TreeBudget* budget) const;
  void publish(std::vector<Claim>& claims);
  void give_back(const std::vector<Claim>& claims);
  void estimate();
  bool wait(const SceneTree& seen, std::span<const std::uint32_t> wanted, const Deadline& deadline);

  const ScenePlan& plan_;
  const GeometryBytes geometry_bytes_;
  const std::shared_ptr<const char> geometry_;
  std::uint64_t least_bytes_ = 0;
  std::uint64_t full_bytes_ = 0;
  std::atomic<std::uint64_t> lasting_bytes_{0};  ///< of the last lasting form; 0: not known
  std::atomic<std::uint64_t> waited_{0};
  std::atomic<std::uint64_t> rejects_{0};
  std::atomic<std::uint64_t> bytes_{0}, held_bytes_{0};
  std::atomic<std::uint64_t> droppable_{0};
  std::atomic<int> users_{0};
  std::atomic<Deadline::Clock::rep> last_use_{0};
  std::atomic<Deadline::Clock::rep> last_drop_{0};

  mutable std::mutex mutex_;  ///< protects the members below; not held while a tree is built
  std::condition_variable changed_;
  std::shared_ptr<const SceneTree> now_;
  std::optional<LazyLayout> layout_;  ///< empty while trees are in the lasting form
  bool moved_ = false;                ///< the trees were in the lasting form before nodes moved
  std::vector<SlotState> states_;
  std::vector<bool> mesh_built_;
  TreeStats stats_;
  std::shared_ptr<TreeBudget> budget_;
};

}  // namespace sightline
