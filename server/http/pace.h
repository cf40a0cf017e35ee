#pragma once
/// How fast a client has to send and to take.

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "server/http/live.h"

namespace sightline {

struct PaceLimits {
  Live<std::uint64_t> bytes_per_second{4096};
  LiveTime window{std::chrono::milliseconds(5'000)};     ///< over which that is an average
  LiveTime longest{std::chrono::milliseconds(600'000)};  ///< for one body or answer, however fast
};

/// Every window has to bring its bytes: who was fast may not be silent for it later.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;
  Pace(const PaceLimits& limits, Clock::time_point now)
      : begin_(now), last_(now + limits.longest.get()), limits_(limits) {}

  void moved(std::uint64_t bytes, Clock::time_point now) {
    bytes_ += bytes;
    const auto window_ms = static_cast<std::uint64_t>(limits_.window.get().count());
    if (bytes_ * 1000 < limits_.bytes_per_second * window_ms) return;
    bytes_ = 0;
    begin_ = now;
  }
  /// Nobody could move anything for so long: it does not count.
  void pause(Clock::duration duration) {
    begin_ += duration;
    if (last_ != Clock::time_point::max()) last_ += duration;
  }
  /// A new window begins, and only the pace counts from here on.
  void restart(Clock::time_point now) {
    bytes_ = 0;
    begin_ = now;
    last_ = Clock::time_point::max();
  }
  /// When it is too slow, unless more has moved by then.
  Clock::time_point due() const { return std::min(begin_ + limits_.window.get(), last_); }

 private:
  Clock::time_point begin_;  ///< of this window
  Clock::time_point last_;
  PaceLimits limits_;
  std::uint64_t bytes_ = 0;  ///< in this window
};

}  // namespace sightline
