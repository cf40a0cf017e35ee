#pragma once
/// DeadlineWatch: a deadline for loops whose steps are shorter than a reading of the clock.
/// ReserveBytes: a function that asks for memory before it is allocated.

#include <cstdint>
#include <functional>

#include "core/base/deadline.h"
#include "core/base/result.h"

namespace sightline {

/// Checks a deadline in a loop, and reads the clock once in `steps_per_look` steps only. The
/// deadline must outlive the watch. Each thread has a watch of its own.
class DeadlineWatch {
 public:
  /// Steps between two readings of the clock where a step visits a node of a tree: some
  /// microseconds.
  static constexpr std::uint64_t kNodes = 64;
  /// The default suits steps of a few nanoseconds, or a hundred for a step that misses every cache.
  explicit DeadlineWatch(const Deadline& deadline, std::uint64_t steps_per_look = 16 << 10)
      : deadline_(deadline), steps_per_look_(steps_per_look) {}
  /// A temporary deadline would not outlive the watch.
  explicit DeadlineWatch(Deadline&& deadline, std::uint64_t steps_per_look = 0) = delete;
  /// Counts `steps` steps. Returns true if the deadline had passed at the last reading of the
  /// clock. The first call reads the clock.
  bool passed(std::uint64_t steps = 1) {
    if (passed_) return true;
    if (left_ > steps) {
      left_ -= steps;
      return false;
    }
    left_ = steps_per_look_;
    passed_ = deadline_.passed();
    return passed_;
  }
  /// The error to return after passed() was true.
  Error error() const { return out_of_time(deadline_); }

 private:
  const Deadline& deadline_;
  const std::uint64_t steps_per_look_;
  std::uint64_t left_ = 0;
  bool passed_ = false;
};

/// Called before `bytes` are allocated; the call may block. It returns success, or the error of the
/// limit that refuses. A null function means no limit.
using ReserveBytes = std::function<Status(std::uint64_t bytes)>;

/// Calls `reserve` and returns its result; success if `reserve` is null.
inline Status ask_for(const ReserveBytes& reserve, std::uint64_t bytes) {
  return reserve ? reserve(bytes) : success();
}

}  // namespace sightline

// Tests: tests/unit/query/similar_names_test.cpp
