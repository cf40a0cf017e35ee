#pragma once
/// Pace: checks that a client sends or receives fast enough.

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "core/base/live.h"

namespace sightline {

/// The least rate of a client, and the longest time of a transfer.
struct PaceLimits {
  Live<std::uint64_t> bytes_per_second{4096};
  LiveTime window{std::chrono::milliseconds(5'000)};  ///< interval over which the rate is averaged
  /// longest time for a body or answer, whatever the rate
  LiveTime longest{std::chrono::milliseconds(600'000)};
};

/// A token bucket for one transfer of one client. Not thread-safe. Each byte allows a silence of
/// the time that it takes at the least rate, at most as long as the averaging interval. So a fast
/// client may not be silent for longer than that interval, and a client at the least rate is never
/// late, however its bytes are divided.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;
  /// Copies `limits`; later changes of its Live members have no effect.
  Pace(const PaceLimits& limits, Clock::time_point now)
      : due_(now + limits.window.get()), last_(now + limits.longest.get()), limits_(limits) {}

  /// Records that `bytes` were transferred.
  void moved(std::uint64_t bytes, Clock::time_point now) {
    const Clock::duration window = limits_.window.get();
    const double seconds = static_cast<double>(bytes) / static_cast<double>(std::max<std::uint64_t>(
                                                            limits_.bytes_per_second, 1));
    const auto longest = std::chrono::duration_cast<std::chrono::duration<double>>(window);
    const std::chrono::duration<double> gained(std::min(seconds, longest.count()));
    due_ = std::min(due_ + std::chrono::duration_cast<Clock::duration>(gained), now + window);
  }
  /// Excludes a duration in which nothing could be transferred.
  void pause(Clock::duration duration) {
    due_ += duration;
    if (last_ != Clock::time_point::max()) last_ += duration;
  }
  /// Begins a new averaging interval; from now on only the rate is checked, not the longest time.
  void restart(Clock::time_point now) {
    due_ = now + limits_.window.get();
    last_ = Clock::time_point::max();
  }
  /// The time at which the client is too slow, unless it transfers more before.
  Clock::time_point due() const { return std::min(due_, last_); }

 private:
  Clock::time_point due_;   ///< limit by the rate
  Clock::time_point last_;  ///< limit by the longest time
  PaceLimits limits_;
};

}  // namespace sightline

// Tests: tests/integration/abuse_test.py
