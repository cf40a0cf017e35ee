#pragma once
/// Threads that run for a moment at a time, beside others that run for long.

#include <chrono>

namespace sightline {

/// The calling thread wants the processor soon and not for long: it may break into the turn of
/// another one. A wish, heard by Linux from 6.12 on; what came before did so by itself.
void ask_for_short_turns();

/// Real-time priority for the calling thread, where the system allows it (CAP_SYS_NICE,
/// RLIMIT_RTPRIO) and has another processor for the other threads. Threads that it starts do not
/// inherit the priority. After it was busy for more than a third of the time, it has normal
/// priority for a second, so that clients cannot monopolise a processor.
class GoingFirst {
 public:
  using Clock = std::chrono::steady_clock;
  GoingFirst();
  /// To be called on the same thread about ten times a second.
  void look(Clock::time_point now);

 private:
  bool allowed_, first_;
  std::chrono::nanoseconds computed_;  ///< by this thread, until the last check
  Clock::time_point looked_, back_until_{};
};

}  // namespace sightline
