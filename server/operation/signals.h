#pragma once
/// SIGTERM, SIGINT and SIGHUP as events that a thread waits for.

#include <chrono>
#include <csignal>
#include <optional>

namespace sightline {

/// Blocks these signals in the thread that makes it, and so in every thread made after: make it
/// before any other thread. They come back with the object.
class Signals {
 public:
  Signals();
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  /// kReload: SIGHUP, but from a terminal that went away, which is kStop as ever.
  enum class Event { kStop, kReload, kWoken, kTimeout };
  /// Waits for the next signal, wake(), or the end of `timeout` (empty: for ever).
  Event wait(std::optional<std::chrono::milliseconds> timeout);
  /// Ends the wait that is going on, or the next one. From any thread.
  void wake();
  /// Lets the signal of the last kStop do what it does where nobody waits for it: it ends the
  /// process. From the thread that waited. It returns only in the first process of a container,
  /// which no signal ends: with the exit code that a shell tells of that signal.
  int let_through();

 private:
  sigset_t before_{};
  int last_stop_ = SIGTERM;
  int signals_ = -1;  ///< a signalfd
  int woken_ = -1;    ///< an eventfd
};

}  // namespace sightline
