#pragma once
/// A deadline for loops whose steps are short beside a look at the clock, and memory that is asked
/// for before it is taken.

#include <cstdint>
#include <functional>

#include "core/base/deadline.h"
#include "core/base/result.h"

namespace sightline {

/// Looks at the clock once in so many steps. The deadline outlives it.
class DeadlineWatch {
 public:
  /// A step takes a few nanoseconds, one that misses every cache a hundred.
  explicit DeadlineWatch(const Deadline& deadline, std::uint64_t steps_per_look = 16 << 10)
      : deadline_(deadline), steps_per_look_(steps_per_look) {}
  /// After so many steps more: whether the time was used up when it looked last, at first at once.
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

/// Asked before so many bytes are taken, which may take time; null where nobody counts them. Its
/// errors are those of whoever counts.
using ReserveBytes = std::function<Status(std::uint64_t bytes)>;

inline Status ask_for(const ReserveBytes& reserve, std::uint64_t bytes) {
  return reserve ? reserve(bytes) : success();
}

}  // namespace sightline
