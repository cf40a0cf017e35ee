#include "core/base/thread_group.h"

#include "core/base/sanitizers.h"

#if !defined(SIGHTLINE_WATCHED_THREADS)

#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include <optional>

#include "core/base/priority.h"

namespace sightline {

struct ThreadGroup::Arena {
  struct Helpers : tbb::task_scheduler_observer {
    using tbb::task_scheduler_observer::task_scheduler_observer;
    ~Helpers() override { observe(false); }
    void on_scheduler_entry(bool is_helper) override {
      if (is_helper) lower_priority();
    }
  };
  tbb::task_arena arena;
  std::optional<Helpers> helpers;
};

void ThreadGroup::start(int threads) {
  if (threads > 0) {
    arena_->arena.initialize(threads);
  } else {
    arena_->arena.initialize();
  }
}

int ThreadGroup::threads() const { return arena_->arena.max_concurrency(); }

void ThreadGroup::give_way() {
  arena_->helpers.emplace(arena_->arena);
  arena_->helpers->observe(true);
}

void ThreadGroup::run(const std::function<void()>& work) { arena_->arena.execute(work); }

}  // namespace sightline

#else

#include <thread>

namespace sightline {

struct ThreadGroup::Arena {
  int threads = 1;
};

void ThreadGroup::start(int threads) {
  arena_->threads = threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency());
}

int ThreadGroup::threads() const { return arena_->threads; }

void ThreadGroup::give_way() {}

void ThreadGroup::run(const std::function<void()>& work) { work(); }

}  // namespace sightline

#endif

namespace sightline {

ThreadGroup::ThreadGroup() : arena_(std::make_unique<Arena>()) {}
ThreadGroup::~ThreadGroup() = default;

}  // namespace sightline
