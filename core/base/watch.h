#pragma once
/// A deadline for loops whose steps are shorter than a reading of the clock, and a function that
/// reserves memory before it is allocated.

#include <cstdint>
#include <functional>

#include "core/base/deadline.h"
#include "core/base/result.h"

namespace sightline {

/// Reads the clock once in so many steps. The deadline must outlive the watch.
class DeadlineWatch {
 public:
  /// A step takes a few nanoseconds, one that misses every cache a hundred.
  explicit DeadlineWatch(const Deadline& deadline, std::uint64_t steps_per_look = 16 << 10)
      : deadline_(deadline), steps_per_look_(steps_per_look) {}
  /// Counts so many steps. Returns whether the time was used up at the last reading of the clock;
  /// the first call reads it.
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
  /// Precondition: it has passed.
  Error error() const { return out_of_time(deadline_); }

 private:
  const Deadline& deadline_;
  const std::uint64_t steps_per_look_;
  std::uint64_t left_ = 0;
  bool passed_ = false;
};

/// Called before so many bytes are allocated; the call may block. Null where no limit applies. It
/// returns the error of the limit that refuses.
using ReserveBytes = std::function<Status(std::uint64_t bytes)>;

inline Status ask_for(const ReserveBytes& reserve, std::uint64_t bytes) {
  return reserve ? reserve(bytes) : success();
}

}  // namespace sightline

// Tests: tests/unit/query/similar_names_test.cpp
