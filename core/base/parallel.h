#pragma once
/// The three patterns in which threads share work, over oneTBB: a loop, two branches and a
/// reduction. thread_group.h limits the number of threads. Headers that other rooms include do not
/// include this file: TBB's headers take 0.7 s to compile.
///
/// ThreadSanitizer does not see the synchronisation inside Debian's libtbb and would report every
/// hand-over as a race. So builds with ThreadSanitizer implement the three patterns with
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

}  // namespace sightline

#endif
