#pragma once
/// Threads that run for a moment at a time, beside others that run for long.

#include <chrono>

namespace sightline {

/// The calling thread wants the processor soon and not for long: it may break into the turn of
/// another one. A wish, heard by Linux from 6.12 on; what came before did so by itself.
void ask_for_short_turns();

/// The thread that makes it runs before all that are scheduled as usual, where that is allowed
/// (CAP_SYS_NICE, RLIMIT_RTPRIO) and leaves them a processor. Threads that it makes do not. One
/// that computes for more than a third of the time is scheduled as usual for a second: who is asked
/// that much would keep all others from the processor, and be asked no more for it.
class GoingFirst {
 public:
  using Clock = std::chrono::steady_clock;
  GoingFirst();
  /// To be called on the same thread about ten times a second.
  void look(Clock::time_point now);

 private:
  bool allowed_, first_;
  std::chrono::nanoseconds computed_;  ///< by this thread, until it looked last
  Clock::time_point looked_, back_until_{};
};

}  // namespace sightline
