#include "core/store/tree_keeper.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <new>
#include <utility>

#include "core/scene/tree_cache.h"
#include "core/store/free_memory.h"

namespace sightline {

namespace {

/// Between two looks at scenes that lost their trees.
constexpr std::chrono::milliseconds kLookAgain{500};

/// Requests go first.
void lower_priority() {
#if defined(__linux__)
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), 10);
#endif
}

}  // namespace

TreeKeeper::TreeKeeper(TreeKeeperOptions options)
    : options_(std::move(options)), budget_(std::make_shared<TreeBudget>(options_.memory_budget)) {
  if (!options_.folder.empty()) folder_.emplace(options_.folder);
  if (!options_.ahead) return;
  builders_.start(options_.threads);
  thread_ = std::thread([this] { run(); });
}

TreeKeeper::~TreeKeeper() {
  {
    const std::lock_guard hold(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Status TreeKeeper::adopt(const std::shared_ptr<const Scene>& scene, const std::string& sha256) {
  if (Status status = scene->trees().join(budget_); !status) return status;
  {
    const std::lock_guard hold(mutex_);
    std::erase_if(scenes_, [](const Adopted& old) { return old.scene.expired(); });
    scenes_.push_back({scene, sha256});
  }
  changed_.notify_all();
  return success();
}

/// The scene that made queries wait most often, of those whose trees are not all there and would
/// fit. Precondition: mutex_ is held.
TreeKeeper::Job TreeKeeper::next() {
  Job hottest;
  std::uint64_t most = 0;
  for (const Adopted& adopted : scenes_) {
    auto scene = adopted.scene.lock();
    if (!scene || adopted.failed || !scene->trees().wants_all()) continue;
    if (!budget_->has_room(scene->trees().full_tree_bytes())) continue;
    const std::uint64_t waited = scene->trees().stats().queries_waited;
    if (hottest.scene && waited <= most) continue;
    most = waited;
    hottest = {std::move(scene), adopted.sha256};
  }
  return hottest;
}

void TreeKeeper::run() {
  lower_priority();
  std::unique_lock hold(mutex_);
  while (!stopping_) {
    if (Job job = next(); job.scene) {
      working_ = true;
      hold.unlock();
      const bool done = complete(job);
      if (!done) give_up(*job.scene);
      job.scene.reset();
      give_back_free_memory();
      hold.lock();
      continue;
    }
    working_ = false;
    changed_.notify_all();
    // A scene may lose its trees, or another one leave room, and nobody says so.
    if (options_.memory_budget > 0) {
      changed_.wait_for(hold, kLookAgain);
    } else {
      changed_.wait(hold);
    }
  }
}

void TreeKeeper::wait_until_idle() {
  if (!options_.ahead) return;
  std::unique_lock hold(mutex_);
  changed_.wait(hold, [&] { return stopping_ || (!working_ && !next().scene); });
}

void TreeKeeper::give_up(const Scene& scene) {
  const std::lock_guard hold(mutex_);
  for (Adopted& adopted : scenes_) {
    if (adopted.scene.lock().get() == &scene) adopted.failed = true;
  }
}

bool TreeKeeper::complete(const Job& job) {
  SceneTrees& trees = job.scene->trees();
  try {
    const std::uint64_t content = folder_ ? content_hash(trees.plan()) : 0;
    if (folder_ && read(job, content)) return true;
    std::optional<Result<SceneTree>> built;
    builders_.execute([&] { built.emplace(build_scene_tree(trees.plan())); });
    if (!*built) {
      say(built->error().code + ": " + built->error().message);
      return false;
    }
    trees.complete(std::move(**built), SceneTrees::Origin::kBuilt);
    if (folder_) write(job, content);
    return true;
  } catch (const std::bad_alloc&) {
    say("there is no memory to build a scene's trees ahead");
    return false;
  }
}

bool TreeKeeper::read(const Job& job, std::uint64_t content) {
  SceneTrees& trees = job.scene->trees();
  std::optional<Result<std::optional<SceneTree>>> stored;
  builders_.execute([&] { stored.emplace(folder_->read(trees.plan(), content, job.sha256)); });
  if (!*stored) {
    trees.count_rejected_file();
    say(stored->error().code + ": " + stored->error().message + "; they are built again");
    return false;
  }
  if (!**stored) return false;
  trees.complete(std::move(***stored), SceneTrees::Origin::kRead);
  return true;
}

void TreeKeeper::write(const Job& job, std::uint64_t content) {
  const auto tree = job.scene->tree();
  if (!tree->complete()) return;
  if (Status status = folder_->write(*tree, content, job.sha256); !status) {
    say(status.error().code + ": " + status.error().message);
  }
  // Its bytes may have gone meanwhile, and with them what was then there of its trees.
  if (job.scene.use_count() == 1 && !job.sha256.empty())
    TreeFolder::forget(options_.folder, job.sha256);
}

void TreeKeeper::say(const std::string& line) const {
  if (options_.report) options_.report(line);
}

}  // namespace sightline
