#pragma once
/// Signals: SIGTERM, SIGINT and SIGHUP as events that a thread waits for.

#include <chrono>
#include <csignal>
#include <optional>

namespace sightline {

/// Waits for SIGTERM, SIGINT and SIGHUP on one thread. The constructor blocks these signals in its
/// thread and in every thread that is started later, so it must be called before any other thread
/// is started. The destructor drops signals that came after the last wait, and restores the mask.
class Signals {
 public:
  Signals();
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  /// kStop: SIGTERM, SIGINT, or SIGHUP from a terminal that was closed. kReload: another SIGHUP.
  /// kWoken: wake() was called.
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
