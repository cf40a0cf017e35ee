#pragma once
/// The four patterns in which threads share work, over oneTBB: a loop, two branches, a reduction,
/// and a group of threads that runs them.
///
/// ThreadSanitizer does not see the synchronisation inside Debian's libtbb and would report every
/// hand-over as a race. So builds with ThreadSanitizer implement the four patterns with
/// std::thread.
///
/// Laws    each call returns after all of its work. If pieces throw, the caller gets one of the
///         exceptions. Calls may nest.

#include <cstddef>

#include "core/base/sanitizers.h"

#if !defined(SIGHTLINE_WATCHED_THREADS)

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include <optional>

#include "core/base/priority.h"

namespace sightline {

/// Calls piece(i) for every i below count, in any order.
template <class Piece>
void parallel_for(std::size_t count, const Piece& piece) {
  tbb::parallel_for(std::size_t{0}, count, piece);
}

/// Calls first() and second(), possibly at the same time.
template <class First, class Second>
void parallel_invoke(const First& first, const Second& second) {
  tbb::parallel_invoke(first, second);
}

/// Returns the reduction of [begin, end): cuts the range into parts, folds each part with value =
/// add(part begin, part end, value), starting with `empty`, and combines neighbours with join(left,
/// right). A part of at most `grain` elements is not cut further; otherwise the cuts are not fixed.
/// So join must be associative, and `empty` neutral.
template <class Value, class Add, class Join>
Value parallel_reduce(std::size_t begin, std::size_t end, std::size_t grain, const Value& empty,
                      const Add& add, const Join& join) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(begin, end, grain), empty,
      [&](const tbb::blocked_range<std::size_t>& range, const Value& value) {
        return add(range.begin(), range.end(), value);
      },
      join);
}

/// A limit of threads: parallel calls inside execute() run on at most threads() threads at once.
/// Use: start(), then execute() from any number of threads.
class ThreadGroup {
 public:
  /// Sets the number of threads; 0: one for each processor. Precondition: called once, before
  /// execute.
  void start(int threads) {
    if (threads > 0) {
      arena_.initialize(threads);
    } else {
      arena_.initialize();
    }
  }
  int threads() const { return arena_.max_concurrency(); }
  /// Lowers the priority of the threads that help the callers of execute, from now on.
  void give_way() {
    helpers_.emplace(arena_);
    helpers_->observe(true);
  }
  /// Calls work() on the calling thread; other threads of the group help with its parallel calls.
  template <class Work>
  void execute(const Work& work) {
    arena_.execute(work);
  }

 private:
  struct Helpers : tbb::task_scheduler_observer {
    using tbb::task_scheduler_observer::task_scheduler_observer;
    ~Helpers() override { observe(false); }
    void on_scheduler_entry(bool is_helper) override {
      if (is_helper) lower_priority();
    }
  };
  tbb::task_arena arena_;
  std::optional<Helpers> helpers_;
};

}  // namespace sightline

#else

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace sightline {

template <class Piece>
void parallel_for(std::size_t count, const Piece& piece) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) piece(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      thrown = std::current_exception();
    }
  };
  // more than the machine may have, so that more orders are seen
  constexpr std::size_t kThreads = 4;
  std::vector<std::thread> threads;
  for (std::size_t i = 1; i < std::min(count, kThreads); ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (thrown) std::rethrow_exception(thrown);
}

template <class First, class Second>
void parallel_invoke(const First& first, const Second& second) {
  parallel_for(2, [&](std::size_t i) {
    if (i == 0) {
      first();
    } else {
      second();
    }
  });
}

template <class Value, class Add, class Join>
Value parallel_reduce(std::size_t begin, std::size_t end, std::size_t grain, const Value& empty,
                      const Add& add, const Join& join) {
  if (begin >= end) return empty;
  std::vector<Value> values((end - begin + grain - 1) / grain, empty);
  parallel_for(values.size(), [&](std::size_t i) {
    const std::size_t from = begin + i * grain;
    values[i] = add(from, std::min(end, from + grain), empty);
  });
  Value sum = empty;
  for (const Value& value : values) sum = join(sum, value);
  return sum;
}

class ThreadGroup {
 public:
  void start(int threads) {
    threads_ = threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency());
  }
  int threads() const { return threads_; }
  void give_way() {}
  template <class Work>
  void execute(const Work& work) {
    work();
  }

 private:
  int threads_ = 1;
};

}  // namespace sightline

#endif
