#pragma once
/// How fast a client has to send and to take.

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "core/base/live.h"

namespace sightline {

struct PaceLimits {
  Live<std::uint64_t> bytes_per_second{4096};
  LiveTime window{std::chrono::milliseconds(5'000)};     ///< over which that is an average
  LiveTime longest{std::chrono::milliseconds(600'000)};  ///< for one body or answer, however fast
};

/// A token bucket. Each byte allows a silence of the time that it takes at the least rate, at most
/// as long as the averaging interval. So a fast client may not be silent for longer than that
/// interval. A client at the least rate is never late, however its bytes are cut.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;
  Pace(const PaceLimits& limits, Clock::time_point now)
      : due_(now + limits.window.get()), last_(now + limits.longest.get()), limits_(limits) {}

  void moved(std::uint64_t bytes, Clock::time_point now) {
    const Clock::duration window = limits_.window.get();
    const double seconds = static_cast<double>(bytes) / static_cast<double>(std::max<std::uint64_t>(
                                                            limits_.bytes_per_second, 1));
    const auto longest = std::chrono::duration_cast<std::chrono::duration<double>>(window);
    const std::chrono::duration<double> gained(std::min(seconds, longest.count()));
    due_ = std::min(due_ + std::chrono::duration_cast<Clock::duration>(gained), now + window);
  }
  /// Nothing could move for so long: the time does not count.
  void pause(Clock::duration duration) {
    due_ += duration;
    if (last_ != Clock::time_point::max()) last_ += duration;
  }
  /// A new averaging interval begins, and only the rate counts from here on.
  void restart(Clock::time_point now) {
    due_ = now + limits_.window.get();
    last_ = Clock::time_point::max();
  }
  /// When it is too slow, unless more has moved by then.
  Clock::time_point due() const { return std::min(due_, last_); }

 private:
  Clock::time_point due_;   ///< by the rate
  Clock::time_point last_;  ///< by the longest time
  PaceLimits limits_;
};

}  // namespace sightline
