#pragma once
/// TreeCacheManager: builds the trees of scenes in the background on its own threads. It stores
/// them in files for the next run, and evicts them from memory beyond a budget.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/base/thread_group.h"
#include "core/scene/scene.h"
#include "core/store/tree_folder.h"

namespace sightline {

/// Options of a cache of trees.
struct TreeCacheOptions {
  /// true: all trees of a scene are built in the background; false: trees are only built for
  /// queries
  bool ahead = true;
  int threads = 1;               ///< threads of background builds
  std::filesystem::path folder;  ///< folder of files of trees; empty: no files
  std::uint64_t disk_budget = TreeFolder::kUsualBytes;  ///< bytes of these files
  /// With an origin, trees of files that it has are taken from there, and stored there; needs a
  /// folder. Null: none.
  std::shared_ptr<OriginScenes> origin = {};
  std::uint64_t memory_budget = 0;  ///< bytes of geometry and trees in total; 0: no limit
  /// What exceeds the memory budget; null: trees are evicted, and scenes are refused
  std::shared_ptr<OverflowMemory> overflow = {};
  /// Called on the background thread with a line about a file that was invalid or could not be
  /// written.
  std::function<void(const std::string& line)> report = {};
};

/// Builds, stores and evicts the trees of the scenes that were adopted. Holds weak references to
/// scenes only. Thread-safe.
class TreeCacheManager {
 public:
  explicit TreeCacheManager(TreeCacheOptions options);
  /// Cancels running builds, fetches and writes, and waits for its threads.
  ~TreeCacheManager();

  /// Takes a scene into the cache and its memory budget.
  /// sha256   hash of the scene's file in the data folder; empty if it is not there
  /// lasting  false: the scene may change soon, so its trees are not written to a file
  /// Errors: SCENE_OVER_BUDGET; the scene is then not in the cache. Each scene is adopted at most
  /// once.
  Status adopt(const std::shared_ptr<const Scene>& scene, const std::string& sha256 = {},
               bool lasting = true);
  /// TreeBudget::overflow_for.
  std::shared_ptr<OverflowMemory> overflow_for(std::uint64_t bytes) const {
    return budget_->overflow_for(bytes);
  }
  /// Waits until no background build is running or due.
  void wait_until_idle();
  /// Statistics over all adopted scenes. Counters include destroyed scenes; byte counts cover only
  /// present ones.
  TreeTotals totals() const { return budget_->totals(); }

 private:
  /// An adopted scene.
  struct Adopted {
    std::weak_ptr<const Scene> scene;
    std::string sha256;
    std::chrono::steady_clock::time_point since;
    bool lasting = true;
    bool failed = false;  ///< its build failed and is not tried again
  };

  void run();
  struct Job {
    std::shared_ptr<const Scene> scene;
    std::string sha256;
    std::chrono::steady_clock::time_point since;  ///< when the scene was adopted
    bool lasting = true;
  };
  /// Returns the jobs that are due now.
  std::vector<Job> next();
  /// Makes all trees of a scene; false if it cannot. Stops when nothing else holds the scene.
  bool complete(const Job& job);
  /// Builds the unbuilt trees of a scene, one by one.
  bool build_pending(SceneTrees& trees, const CancelFlag& cancel);
  void give_up(const Scene& scene);
  /// Copies the trees from the origin to the folder, if it has them.
  void fetch(const Job& job, std::uint64_t content, const CancelFlag& cancel);
  bool read(const Job& job, std::uint64_t content);
  void write(const Job& job, std::uint64_t content, const CancelFlag& cancel);
  /// Removes the files of trees of a scene that has gone meanwhile: its bytes may have gone too, and
  /// with them what was then there of its trees.
  void forget_if_gone(const Job& job) const;
  void say_error(const Error& error) noexcept;
  /// Reports a line made of these words; does nothing if there is no memory for it.
  void say(std::initializer_list<std::string_view> words) const noexcept;

  const TreeCacheOptions options_;
  const std::shared_ptr<TreeBudget> budget_;
  std::optional<TreeFolder> folder_;
  ThreadGroup builders_;
  std::chrono::steady_clock::time_point fetches_again_{};  ///< of the background thread

  std::mutex mutex_;  ///< protects the members below
  std::condition_variable changed_;
  std::vector<Adopted> scenes_;
  bool working_ = false;
  bool stopping_ = false;
  CancelFlag cancel_;  ///< set with stopping_
  std::thread thread_;
};

}  // namespace sightline
