#pragma once
/// The tree cache manager: builds the trees of scenes in the background, on its own thread. It
/// stores them in files between two runs and holds them in memory within a budget.

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
#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/scene/scene.h"
#include "core/store/tree_folder.h"

namespace sightline {

struct TreeCacheOptions {
  bool ahead = true;                ///< false: trees are built when rays come near, and only then
  int threads = 1;                  ///< of background builds
  std::filesystem::path folder;     ///< of files of trees; empty: there are none
  std::uint64_t memory_budget = 0;  ///< bytes of geometry and trees in total; 0: no limit
  /// Called with files that were refused or could not be written, on the thread that builds.
  std::function<void(const std::string& line)> report = {};
};

/// May be used from many threads. Holds no scene alive.
class TreeCacheManager {
 public:
  explicit TreeCacheManager(TreeCacheOptions options);
  /// Aborts builds and writes in progress.
  ~TreeCacheManager();

  /// sha256   of the bytes in the data folder that the scene was made of; empty: not in the data folder
  /// lasting  false: the scene may change soon, so its trees are not written to a file
  ///
  /// Errors: SCENE_OVER_BUDGET.
  Status adopt(const std::shared_ptr<const Scene>& scene, const std::string& sha256 = {},
               bool lasting = true);
  /// Returns when no background build is left.
  void wait_until_idle();
  /// Statistics over all adopted scenes. Event counters include destroyed scenes. Byte counts cover
  /// only scenes that still exist.
  TreeTotals totals() const { return budget_->totals(); }

 private:
  struct Adopted {
    std::weak_ptr<const Scene> scene;
    std::string sha256;
    std::chrono::steady_clock::time_point since;
    bool lasting = true;
    bool failed = false;  ///< is not tried again
  };

  void run();
  struct Job {
    std::shared_ptr<const Scene> scene;
    std::string sha256;
    std::chrono::steady_clock::time_point since;  ///< when it came
    bool lasting = true;
  };
  /// The jobs to do before the state is read again.
  std::vector<Job> next();
  bool complete(const Job& job);
  /// Builds the unbuilt trees, one by one.
  bool build_pending(SceneTrees& trees);
  void give_up(const Scene& scene);
  bool read(const Job& job, std::uint64_t content);
  void write(const Job& job, std::uint64_t content);
  /// One line of these; nothing where there is no memory to say it.
  void say(std::initializer_list<std::string_view> words) const noexcept;

  const TreeCacheOptions options_;
  const std::shared_ptr<TreeBudget> budget_;
  std::optional<TreeFolder> folder_;
  ThreadGroup builders_;

  std::mutex mutex_;  ///< for what follows
  std::condition_variable changed_;
  std::vector<Adopted> scenes_;
  bool working_ = false;
  bool stopping_ = false;
  CancelFlag cancel_;  ///< is set with it
  std::thread thread_;
};

}  // namespace sightline
