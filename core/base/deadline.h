#pragma once
/// Deadline and cancel flag: how long a piece of work may take, on how many threads, and whether its
/// caller still waits for the result.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>

#include "core/base/result.h"

namespace sightline {

/// A flag that one thread sets and others read. It must outlive every Deadline that refers to it.
class CancelFlag {
 public:
  CancelFlag() = default;
  /// A flag for work on an object that the caller holds: it is also set, for ever, by a call of
  /// cancelled() that finds `outer` set or that nobody else holds the object. `outer` must outlive
  /// the flag.
  template <class T>
  CancelFlag(const CancelFlag& outer, const std::shared_ptr<T>& held)
      : outer_(&outer), held_(held) {}

  /// Sets the flag for ever. Thread-safe.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const {
    if (outer_ != nullptr && (outer_->cancelled() || held_.use_count() <= 1))
      cancelled_.store(true, std::memory_order_relaxed);
    return cancelled_.load(std::memory_order_relaxed);
  }

 private:
  mutable std::atomic<bool> cancelled_{false};
  const CancelFlag* outer_ = nullptr;
  std::weak_ptr<const void> held_;
};

/// True if `flag` is set; a null flag is never set.
inline bool is_cancelled(const CancelFlag* flag) { return flag != nullptr && flag->cancelled(); }

/// How far work is: pieces that are done, and pieces that are known so far. Work adds to it, and any
/// thread may read it.
struct WorkProgress {
  std::atomic<std::uint64_t> done{0}, all{0};
};

/// Bounds of a piece of work. It ends at a time, or when one of two flags is set; the flags must
/// outlive it.
/// By default it never passes. Copies are cheap, and any thread may read them.
struct Deadline {
  using Clock = std::chrono::steady_clock;
  /// The time at which the work must end.
  Clock::time_point at = Clock::time_point::max();
  /// Set when the work is to be cancelled; may be null.
  const CancelFlag* flag = nullptr;
  /// set when the caller no longer waits for the answer; may be null
  const CancelFlag* caller = nullptr;
  /// the most threads of an engine that work on it at once; 0: all
  int threads = 0;
  WorkProgress* progress = nullptr;  ///< where it is told how far the work is; may be null

  /// A deadline that never passes.
  static Deadline never() { return {}; }
  /// A deadline that passes after `duration` from now, or when `flag` is set; `flag` may be null.
  static Deadline in(Clock::duration duration, const CancelFlag* flag = nullptr) {
    return {Clock::now() + duration, flag, nullptr};
  }
  /// True if one of the flags is set.
  bool cancelled() const { return is_cancelled(flag) || is_cancelled(caller); }
  /// True if the time has come, or one of the flags is set. Reads the clock.
  bool passed() const {
    return cancelled() || (at != Clock::time_point::max() && Clock::now() >= at);
  }
};

/// The error to return for a deadline that has passed: CANCELLED or DEADLINE. Precondition:
/// deadline.passed().
inline Error out_of_time(const Deadline& deadline) {
  if (deadline.cancelled()) {
    return {ErrorKind::kCancelled, "CANCELLED", "the request was cancelled", ""};
  }
  return {ErrorKind::kDeadline, "DEADLINE", "the time allowed was used up", ""};
}

}  // namespace sightline

// Tests: tests/unit/run/engine_test.cpp
