#pragma once
/// Engine::State: the internals of an engine, for the files that implement it. A slice is a range
/// of the queries of a batch that one thread answers at a time.

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/thread_group.h"
#include "core/base/within_memory.h"
#include "core/run/engine.h"
#include "core/trace/kernel/kernel.h"

namespace sightline {

/// Rays in a slice. Large enough that the cost of taking slices is hidden, and small enough that a
/// deadline is noticed within about a millisecond.
inline constexpr std::size_t kSlice = 1024;
/// Rays in a slice of a query that lists every hit, because one ray may meet a whole scene.
inline constexpr std::size_t kListSlice = 64;

/// The error of a query that must not build trees (RayOptions::builds).
inline Error trees_are_unbuilt() {
  return {ErrorKind::kBusy, "TREES_PENDING", "trees of the scene are not built yet", ""};
}

/// Runs a whole query, answer(), and turns std::bad_alloc into the error MEMORY_EXHAUSTED. The
/// largest allocations of a query are outside of slices: columns that are resized before the
/// threads work, and lists that are joined afterwards.
template <class Answer>
Status within_memory(const Answer& answer) {
  return within_memory("there is no memory for the answer", answer);
}

/// Sums the work of the slices of a query if the caller asked for it, and records whether a slice
/// was abandoned because of the deadline. A query makes one log; each slice makes an Entry. The
/// scene and `work` (may be null) must outlive the log.
class WorkLog {
 public:
  WorkLog(const Scene& scene, QueryWork* work) : scene_(scene), work_(work) {
    if (work_ != nullptr) trees_before_ = scene_.trees().trees_built();
  }
  ~WorkLog() {
    if (work_ != nullptr) work_->trees_built += scene_.trees().trees_built() - trees_before_;
  }
  WorkLog(const WorkLog&) = delete;
  WorkLog& operator=(const WorkLog&) = delete;

  /// Adds the counts of a slice at the end of its scope. The log and the counts must outlive it.
  class Entry {
   public:
    Entry(WorkLog& log, const TraceCounts& counts) : log_(log), counts_(counts) {}
    ~Entry() {
      if (counts_.stopped) log_.stopped_.store(true, std::memory_order_relaxed);
      if (log_.work_ != nullptr) log_.add(counts_);
    }
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;

   private:
    WorkLog& log_;
    const TraceCounts& counts_;
  };

  /// The result of a query whose slices ended with `status`: the error of the deadline if a slice
  /// was abandoned.
  Status checked(Status status, const Deadline& deadline) const {
    const bool abandoned = status && stopped_.load(std::memory_order_relaxed);
    return abandoned ? Status(out_of_time(deadline)) : std::move(status);
  }

 private:
  void add(const TraceCounts& counts) {
    const std::lock_guard hold(mutex_);
    work_->nodes += counts.nodes + counts.packet_nodes;
    work_->blocks += counts.blocks;
    work_->placements += counts.placements;
    work_->exact_hits += counts.decisions.exact_hits;
    work_->exact_compares += counts.decisions.exact_compares;
    work_->exact_roundings += counts.decisions.exact_roundings;
  }

  const Scene& scene_;
  QueryWork* work_;
  std::atomic<bool> stopped_{false};
  std::uint64_t trees_before_ = 0;
  std::mutex mutex_;
};

/// Limits how many batches run at once to the number of threads; each holds a turn while it runs.
/// Other batches wait for a turn, so that their data does not displace that of running batches from
/// caches. A batch waits for at most kPatience and at most until its deadline, and then runs
/// anyway, because a running batch may take minutes.
class Turns {
 public:
  static constexpr std::chrono::milliseconds kPatience{20};

  /// Sets the number of threads and the longest wait. Precondition: called once, before any turn is
  /// taken.
  void start(int threads, std::chrono::milliseconds patience = kPatience) {
    threads_ = threads;
    patience_ = patience;
  }
  /// True if there are at least as many batches, running or waiting, as threads. Then no thread is
  /// idle, and sharing a batch between threads would gain nothing.
  bool all_wanted() const { return wanted_.load(std::memory_order_relaxed) >= threads_; }

  /// A turn: the constructor waits for it, the destructor ends it. `turns` must outlive it.
  class Turn {
   public:
    Turn(Turns& turns, const Deadline& deadline) : turns_(turns) {
      turns_.wanted_.fetch_add(1, std::memory_order_relaxed);
      std::unique_lock hold(turns_.mutex_);
      const auto due = std::min(deadline.at, Deadline::Clock::now() + turns_.patience_);
      turns_.free_.wait_until(hold, due, [&] { return turns_.taken_ < turns_.threads_; });
      ++turns_.taken_;
    }
    ~Turn() {
      {
        const std::lock_guard hold(turns_.mutex_);
        --turns_.taken_;
      }
      turns_.wanted_.fetch_sub(1, std::memory_order_relaxed);
      turns_.free_.notify_one();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Turns& turns_;
  };

 private:
  int threads_ = 0;
  std::chrono::milliseconds patience_ = kPatience;
  std::mutex mutex_;
  std::condition_variable free_;
  int taken_ = 0;
  std::atomic<int> wanted_{0};  ///< batches that run or wait
};

/// Calls take(i) once for each i in [begin, end), on at most `most` threads of the group at once; 0:
/// on all of them.
template <class Take>
void share(ThreadGroup& threads, std::size_t begin, std::size_t end, int most, const Take& take) {
  const std::size_t count = end - begin;
  if (most == 0 || most >= threads.threads() || static_cast<std::size_t>(most) >= count) {
    threads.execute([&] { parallel_for(count, [&](std::size_t i) { take(begin + i); }); });
    return;
  }
  std::atomic<std::size_t> next{begin};
  const auto take_some = [&](std::size_t) {
    for (std::size_t i = next++; i < end; i = next++) take(i);
  };
  threads.execute([&] { parallel_for(static_cast<std::size_t>(most), take_some); });
}

class TreeGroups;

/// The members of an engine. run() answers a batch; with_trees() and trace_again() build the trees
/// that it needs (unbuilt_rounds.h).
struct Engine::State {
  Kernel kernel;
  std::string kernel_name;
  ThreadGroup threads;                              ///< run the slices of batches
  Turns turns;                                      ///< limit how many batches run at once
  const std::atomic<bool>* should_yield = nullptr;  ///< EngineOptions::should_yield
  std::atomic<std::size_t> group_read{0};           ///< the last one of by_groups(), of any scene

  /// Calls the kernel for the hit lists of rays [begin, end), with or without a filter.
  void all(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
           const RayOptions& options, const KernelLists& lists, TraceCounts& counts) const {
    if (options.resolved != nullptr) {
      kernel.all_filtered(scene, rays, begin, end, *options.resolved, lists, counts);
    } else {
      kernel.all(scene, rays, begin, end, lists, counts);
    }
  }

  /// Calls slice(begin, end) for slices of [0, count), at most slice_size long, in parallel if other
  /// threads are idle, on at most deadline.threads of them. No slice starts after the deadline.
  /// Errors: DEADLINE, CANCELLED; some slices may then not have run. Throws what a slice throws.
  template <class Slice>
  Status run(std::size_t count, const Deadline& deadline, Slice slice,
             std::size_t slice_size = kSlice) {
    if (deadline.passed()) return out_of_time(deadline);
    if (count == 0) return success();
    const std::size_t slices = (count + slice_size - 1) / slice_size;
    if (deadline.progress != nullptr) deadline.progress->all += slices;
    if (slices == 1) {
      slice(std::size_t{0}, count);
      if (deadline.progress != nullptr) ++deadline.progress->done;
      return success();
    }
    const Turns::Turn turn(turns, deadline);
    std::atomic<bool> stopped{false};
    const auto take = [&](std::size_t i) {
      if (stopped.load(std::memory_order_relaxed)) return;
      if (deadline.passed()) {
        stopped.store(true, std::memory_order_relaxed);
        return;
      }
      slice(i * slice_size, std::min(count, (i + 1) * slice_size));
      if (deadline.progress != nullptr) ++deadline.progress->done;
      // Without sched_yield the waiting thread would run only at the scheduler's next tick,
      // milliseconds later.
      if (should_yield != nullptr && should_yield->load(std::memory_order_relaxed)) ::sched_yield();
    };
    // Sharing slices between threads costs time, so it is done only if a thread is idle.
    std::size_t alone = 0;
    while (alone < slices && (deadline.threads == 1 || turns.all_wanted())) take(alone++);
    if (alone < slices) share(threads, alone, slices, deadline.threads, take);
    if (stopped.load()) return out_of_time(deadline);
    return success();
  }

  /// Traces a batch in one group after the other. Errors: those of run.
  ///
  /// limit(i)  tmax of ray i for the groups to come; NaN or below its tmin: it needs none of them
  /// trace(view, rays, numbers)  traces some rays in a group, and adds what it finds to the answers
  ///           of the rays `numbers` of the batch; several threads call it at once
  template <class Limit, class Trace>
  Status by_groups(TreeGroups& groups, const RayBatch& rays, const Deadline& deadline, Limit limit,
                   Trace trace);

  /// For queries that need every tree near them. Builds the trees that queries [0, count) need, and
  /// returns a view of the scene with these trees. find(unbuilt, i, trees) appends to `trees` the
  /// trees near query i that `unbuilt` (UnbuiltTrees) reports; several threads call it at once.
  /// Errors: those of SceneTrees::build.
  template <class Find>
  Result<SceneView> with_trees(const Scene& scene, std::size_t count, const Deadline& deadline,
                               Find find);

  /// For rays that were traced in `view` while trees were unbuilt. Repeats three steps until no ray
  /// needs another tree. nearest(unbuilt, numbers, next) sets next[k] to the unbuilt tree that ray
  /// numbers[k] needs next, or kNone; several threads call it at once. These trees are built.
  /// again(view, numbers) traces the rays `numbers` again. Errors: those of SceneTrees::build and
  /// of again.
  template <class Nearest, class Again>
  Status trace_again(SceneView view, std::size_t count, const Deadline& deadline, Nearest nearest,
                     Again again);
};

}  // namespace sightline

// Tests: tests/unit/run/engine_test.cpp
