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
#include "core/scene/tree_stats.h"

namespace sightline {

/// May be used from many threads. What now() returns never changes: later states are other objects.
class SceneTrees {
 public:
  /// Nothing is built. The plan outlives it.
  explicit SceneTrees(const ScenePlan& plan, std::uint64_t geometry_bytes);

  std::shared_ptr<const SceneTree> now() const;

  /// Builds the `wanted` trees of `seen`, which now() returned, each once, whoever asks: returns
  /// when those are there that other threads had begun. A tree that is large may be cut instead, so
  /// that some of its parts are still pending. Returns a state that has what was built, or, if all
  /// trees were exchanged meanwhile, the present one. Must not be called by work that runs on
  /// `threads`. Errors: DEADLINE and CANCELLED; also throws std::bad_alloc, and nothing has changed
  /// then.
  Result<std::shared_ptr<const SceneTree>> build(const std::shared_ptr<const SceneTree>& seen,
                                                 std::span<const std::uint32_t> wanted,
                                                 const Deadline& deadline, ThreadGroup& threads);

  /// How all trees came to be there.
  enum class Origin { kBuilt, kRead };
  /// Puts all trees in the place of what is there.
  void complete(SceneTree tree, Origin origin);
  /// Lets go of all trees: everything is pending again. Throws std::bad_alloc.
  void drop();

  void count_waiting(std::uint64_t queries) { waited_.fetch_add(queries); }
  void count_rejected_file() { rejects_.fetch_add(1); }
  TreeStats stats() const;
  const ScenePlan& plan() const { return plan_; }

 private:
  enum class SlotState : std::uint8_t { kPending, kBuilding, kDone };
  /// What a thread has taken on.
  struct Claim {
    std::uint32_t number = 0;
    TreeSlot slot;
    std::shared_ptr<const WideTree> tree;  ///< when built
    std::vector<MeshPart> parts;           ///< when cut
  };

  bool is_present(const SceneTree& seen) const { return layout_ && seen.unbuilt == now_->unbuilt; }
  std::vector<Claim> claim(std::span<const std::uint32_t> wanted);
  void make(Claim& claim) const;
  void publish(std::vector<Claim>& claims);
  void give_back(const std::vector<Claim>& claims);
  bool wait(const SceneTree& seen, std::span<const std::uint32_t> wanted, const Deadline& deadline);

  const ScenePlan& plan_;
  const std::uint64_t geometry_bytes_;
  std::atomic<std::uint64_t> waited_{0};
  std::atomic<std::uint64_t> rejects_{0};

  mutable std::mutex mutex_;  ///< for what follows; not held while a tree is built
  std::condition_variable changed_;
  std::shared_ptr<const SceneTree> now_;
  std::optional<LazyLayout> layout_;  ///< none once all trees are there
  std::vector<SlotState> states_;
  std::vector<bool> mesh_built_;
  TreeStats stats_;
};

}  // namespace sightline
