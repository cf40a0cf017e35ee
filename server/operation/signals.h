#pragma once
/// Signals: SIGTERM, SIGINT and SIGHUP as events that a thread waits for.

#include <chrono>
#include <csignal>
#include <optional>

namespace sightline {

/// The constructor blocks these signals in its thread and in every thread that is started later, so
/// it must be made before any other thread. The destructor unblocks them.
class Signals {
 public:
  Signals();
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  /// kReload: SIGHUP. But if it comes from a terminal that was closed, it is kStop.
  enum class Event { kStop, kReload, kWoken, kTimeout };
  /// Waits for the next signal, for wake(), or for `timeout` (empty: no timeout).
  Event wait(std::optional<std::chrono::milliseconds> timeout);
  /// Ends the present or the next wait(). Thread-safe.
  void wake();
  /// Performs the default action of the signal of the last kStop, which ends the process. Must be
  /// called on the waiting thread. It returns only in the first process of a container, which no
  /// signal ends; the result is the exit code that a shell shows for the signal.
  int let_through();

 private:
  sigset_t before_{};
  int last_stop_ = SIGTERM;
  int signals_ = -1;  ///< a signalfd
  int woken_ = -1;    ///< an eventfd
};

}  // namespace sightline
