#pragma once
/// The internals of an engine, for the files that implement it.

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>

#include "core/base/parallel.h"
#include "core/base/within_memory.h"
#include "core/run/engine.h"
#include "core/trace/kernel/kernel.h"

namespace sightline {

/// Rays that one thread takes at a time: enough to hide the cost of taking them, few enough that a
/// deadline is noticed within a millisecond or so.
inline constexpr std::size_t kSlice = 1024;
/// Rays in a slice where every hit is listed: one ray may meet a whole scene.
inline constexpr std::size_t kListSlice = 64;

inline Error trees_are_unbuilt() {
  return {ErrorKind::kBusy, "TREES_PENDING", "trees of the scene are not built yet", ""};
}

/// Around the whole of an answer: the columns that it resizes before and the lists that it joins
/// after the threads' work are the largest that it has.
template <class Answer>
Status within_memory(const Answer& answer) {
  return within_memory("there is no memory for the answer", answer);
}

/// Adds up the work of the slices of a query if the caller asked for it. Records whether a slice
/// was abandoned.
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

  /// Adds the counts of a slice when the slice is over.
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

  /// The result of a sliced query: `status`, or the error of the deadline.
  Status checked(Status status, const Deadline& deadline) const {
    return status && stopped_.load(std::memory_order_relaxed) ? out_of_time(deadline) : status;
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

/// Batches take turns: as many at once as there are threads. The others wait, and what they have
/// decoded stays in nobody's way. They do not wait for long, nor beyond their deadlines: a batch
/// may take minutes, and the processor can be shared in other ways too.
class Turns {
 public:
  static constexpr std::chrono::milliseconds kPatience{20};

  /// Precondition: called once, before any turn is taken.
  void start(int threads, std::chrono::milliseconds patience = kPatience) {
    threads_ = threads;
    patience_ = patience;
  }
  /// Whether every thread has a batch of its own, or will at once, so that nobody is idle to help
  /// with one.
  bool all_wanted() const { return wanted_.load(std::memory_order_relaxed) >= threads_; }

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
  std::atomic<int> wanted_{0};  ///< those that are taken, and those that are waited for
};

struct Engine::State {
  Kernel kernel;
  std::string kernel_name;
  ThreadGroup threads;
  Turns turns;
  const std::atomic<bool>* should_yield = nullptr;

  void all(const SceneView& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
           const RayOptions& options, const KernelLists& lists, TraceCounts& counts) const {
    if (options.resolved != nullptr) {
      kernel.all_filtered(scene, rays, begin, end, *options.resolved, lists, counts);
    } else {
      kernel.all(scene, rays, begin, end, lists, counts);
    }
  }

  /// Calls slice(begin, end) over [0, count) on the threads of this engine until the deadline.
  /// Throws what a slice throws.
  template <class Slice>
  Status run(std::size_t count, const Deadline& deadline, Slice slice,
             std::size_t slice_size = kSlice) {
    if (deadline.passed()) return out_of_time(deadline);
    if (count == 0) return success();
    if (count <= slice_size) {
      slice(std::size_t{0}, count);
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
      // Without sched_yield the scheduler runs again at its next tick, milliseconds later.
      if (should_yield != nullptr && should_yield->load(std::memory_order_relaxed)) ::sched_yield();
    };
    // To hand slices over takes time, and pays where somebody is idle.
    const std::size_t slices = (count + slice_size - 1) / slice_size;
    std::size_t alone = 0;
    while (alone < slices && turns.all_wanted()) take(alone++);
    if (alone < slices) {
      threads.execute(
          [&] { parallel_for(slices - alone, [&](std::size_t i) { take(alone + i); }); });
    }
    if (stopped.load()) return out_of_time(deadline);
    return success();
  }

  /// For queries that need every tree near them. Returns a view in which the trees near queries [0,
  /// count) are built. find(`unbuilt`, i, trees) appends the trees near query i.
  template <class Find>
  Result<SceneView> with_trees(const Scene& scene, std::size_t count, const Deadline& deadline,
                               Find find);

  /// For rays that were traced while trees were unbuilt. nearest(`unbuilt`, i) returns the tree
  /// that ray i needs next, or kNone. again(view, numbers) traces those rays again. Returns when no
  /// ray needs a tree.
  template <class Nearest, class Again>
  Status trace_again(SceneView view, std::size_t count, const Deadline& deadline, Nearest nearest,
                     Again again);
};

}  // namespace sightline

// Tests: tests/unit/run/engine_test.cpp
