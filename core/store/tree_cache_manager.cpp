#include "core/store/tree_cache_manager.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <numeric>
#include <utility>

#include "core/base/free_memory.h"
#include "core/base/priority.h"
#include "core/scene/tree_cache.h"

namespace sightline {

namespace {

/// Between two checks of scenes that lost their trees.
constexpr std::chrono::milliseconds kLookAgain{500};

/// For a scene that has just come: its client may ask at once, and the first answer cuts a large
/// mesh with all threads. Its trees would be read or built beside that for seconds anyway.
constexpr std::chrono::milliseconds kHeadStart{100};

/// After a fetch that failed. Meanwhile trees are built, so scenes do not wait one after the other for
/// an origin that does not answer.
constexpr std::chrono::seconds kFetchesAgain{10};

/// Bytes of finished trees that replace the first ones at once: each time all entries are copied.
constexpr std::uint64_t kReplacedAtOnce = 256u << 20;

/// To choose one scene so many more are checked; or else ten thousand small ones would be checked
/// ten thousand times.
constexpr std::size_t kLookedAtForEach = 256;

}  // namespace

TreeCacheManager::TreeCacheManager(TreeCacheOptions options)
    : options_(std::move(options)),
      budget_(std::make_shared<TreeBudget>(options_.memory_budget, options_.overflow)) {
  if (!options_.folder.empty()) folder_.emplace(options_.folder, options_.disk_budget);
  if (!options_.ahead) return;
  builders_.start(options_.threads);
  thread_ = std::thread([this] { run(); });
}

TreeCacheManager::~TreeCacheManager() {
  cancel_.cancel();
  {
    const std::lock_guard hold(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Status TreeCacheManager::adopt(const std::shared_ptr<const Scene>& scene, const std::string& sha256,
                               bool lasting) {
  if (Status status = scene->trees().join(budget_); !status) return status;
  budget_->settle();
  // Nobody would build them, nor check which of them are gone.
  if (!options_.ahead) return success();
  {
    const std::lock_guard hold(mutex_);
    scenes_.push_back({scene, sha256, std::chrono::steady_clock::now(), lasting});
  }
  changed_.notify_all();
  return success();
}

/// The scene that made queries wait most often, of those whose trees are not all there and would
/// fit; some more of many. Precondition: mutex_ is held.
std::vector<TreeCacheManager::Job> TreeCacheManager::next() {
  struct Candidate {
    std::uint64_t waited;
    Job job;
  };
  std::vector<Candidate> candidates;
  const std::uint64_t room = budget_->room();
  // Without a budget trees that are all there stay there, and no further check is needed.
  std::erase_if(scenes_, [&](const Adopted& adopted) {
    auto scene = adopted.scene.lock();
    if (!scene || adopted.failed) return true;
    const SceneTrees& trees = scene->trees();
    if (!trees.wants_all()) return options_.memory_budget == 0;
    if (trees.lasting_build_bytes() > room) return false;
    candidates.push_back({trees.stats().queries_waited,
                          {std::move(scene), adopted.sha256, adopted.since, adopted.lasting}});
    return false;
  });
  const std::size_t count = std::min(candidates.size(), 1 + candidates.size() / kLookedAtForEach);
  std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
                    candidates.end(),
                    [](const Candidate& a, const Candidate& b) { return a.waited > b.waited; });
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < count; ++i) jobs.push_back(std::move(candidates[i].job));
  return jobs;
}

void TreeCacheManager::run() {
  lower_priority();  // requests go first
  std::unique_lock hold(mutex_);
  while (!stopping_) {
    // A scene may lose its trees, or another one leave room, and nobody says so.
    bool looks_again = options_.memory_budget > 0;
    std::vector<Job> jobs;
    try {
      jobs = next();
    } catch (const std::bad_alloc&) {
      looks_again = true;  // there may be memory to choose then
    }
    if (!jobs.empty()) {
      working_ = true;
      for (Job& job : jobs) {
        changed_.wait_until(hold, job.since + kHeadStart, [this] { return stopping_; });
        if (stopping_) break;
        hold.unlock();
        const std::uint64_t bytes = job.scene->trees().full_tree_bytes();
        if (!complete(job)) give_up(*job.scene);
        job.scene.reset();
        give_back_free_memory_of(bytes);
        hold.lock();
      }
      continue;
    }
    working_ = false;
    changed_.notify_all();
    if (looks_again) {
      changed_.wait_for(hold, kLookAgain);
    } else {
      changed_.wait(hold);
    }
  }
}

void TreeCacheManager::wait_until_idle() {
  if (!options_.ahead) return;
  std::unique_lock hold(mutex_);
  changed_.wait(hold, [&] { return stopping_ || (!working_ && next().empty()); });
}

void TreeCacheManager::give_up(const Scene& scene) {
  const std::lock_guard hold(mutex_);
  for (Adopted& adopted : scenes_) {
    if (adopted.scene.lock().get() == &scene) adopted.failed = true;
  }
}

bool TreeCacheManager::complete(const Job& job) {
  SceneTrees& trees = job.scene->trees();
  const CancelFlag cancel(cancel_, job.scene);
  try {
    if (trees.is_moved()) return build_pending(trees, cancel);
    const bool keeps = folder_ && job.lasting;
    // Here too no more threads than its own: a first ray may be on its way.
    std::uint64_t content = 0;
    if (keeps) builders_.execute([&] { content = content_hash(trees.plan()); });
    if (keeps && options_.origin && !job.sha256.empty()) fetch(job, content, cancel);
    if (keeps && read(job, content)) return true;
    std::optional<Result<SceneTree>> built;
    std::vector<FinishedTree> finished;
    std::uint64_t bytes = 0;
    const std::uint64_t at_once = std::max(kReplacedAtOnce, trees.full_tree_bytes() / 16);
    const auto replace = [&](FinishedTree tree) {
      bytes += tree.tree->arena.used();
      finished.push_back(std::move(tree));
      if (bytes < at_once) return;
      trees.replace(finished);
      finished.clear();
      give_back_free_memory_of(std::exchange(bytes, 0));
    };
    builders_.execute([&] {
      built.emplace(
          build_scene_tree(trees.plan(), TreeQuality::kHigh, Joining::kMeasured, &cancel, replace));
    });
    if (cancel.cancelled()) return false;
    if (!*built) {
      say({built->error().code, ": ", built->error().message});
      return false;
    }
    trees.complete(std::move(**built), SceneTrees::Origin::kBuilt);
    if (keeps) write(job, content, cancel);
    return true;
  } catch (const std::bad_alloc&) {
    say({"there is no memory to build a scene's trees in the background"});
    return false;
  }
}

bool TreeCacheManager::build_pending(SceneTrees& trees, const CancelFlag& cancel) {
  const auto tree = trees.now();
  std::vector<std::uint32_t> all(tree->trees.size());
  std::iota(all.begin(), all.end(), 0u);
  const auto built = trees.build(tree, all, {.flag = &cancel}, builders_);
  if (!built && !cancel.cancelled()) say({built.error().code, ": ", built.error().message});
  return built.ok();
}

void TreeCacheManager::fetch(const Job& job, std::uint64_t content, const CancelFlag& cancel) {
  if (std::chrono::steady_clock::now() < fetches_again_) return;
  const Status fetched = folder_->fetch(*options_.origin, content, job.sha256, &cancel);
  if (fetched || fetched.error().kind == ErrorKind::kCancelled) return forget_if_gone(job);
  fetches_again_ = std::chrono::steady_clock::now() + kFetchesAgain;
  say_error(fetched.error());
}

void TreeCacheManager::forget_if_gone(const Job& job) const {
  if (job.scene.use_count() == 1 && !job.sha256.empty())
    TreeFolder::forget(options_.folder, job.sha256);
}

bool TreeCacheManager::read(const Job& job, std::uint64_t content) {
  SceneTrees& trees = job.scene->trees();
  std::optional<Result<std::optional<SceneTree>>> stored;
  builders_.execute([&] { stored.emplace(folder_->read(trees.plan(), content, job.sha256)); });
  if (!*stored) {
    trees.count_rejected_file();
    say({stored->error().code, ": ", stored->error().message, "; they are built again"});
    return false;
  }
  if (!**stored) return false;
  trees.complete(std::move(***stored), SceneTrees::Origin::kRead);
  return true;
}

void TreeCacheManager::write(const Job& job, std::uint64_t content, const CancelFlag& cancel) {
  const auto tree = job.scene->tree();
  if (!tree->complete()) return;
  const Status status = folder_->write(*tree, content, job.sha256, &cancel);
  if (!status && status.error().kind != ErrorKind::kCancelled) say_error(status.error());
  if (status && options_.origin && !job.sha256.empty()) {
    const Status published = folder_->publish(*options_.origin, content, job.sha256);
    if (!published) say_error(published.error());
  }
  forget_if_gone(job);
}

void TreeCacheManager::say_error(const Error& error) noexcept {
  say({error.code, ": ", error.message});
}

void TreeCacheManager::say(std::initializer_list<std::string_view> words) const noexcept {
  try {
    std::string line;
    for (const std::string_view word : words) line += word;
    if (options_.report) options_.report(line);
  } catch (...) {
    // Nobody waits for this line, and the thread has to go on.
  }
}

}  // namespace sightline
