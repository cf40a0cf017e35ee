#pragma once
/// SIGTERM and SIGINT as events that a thread waits for.

#include <chrono>
#include <csignal>
#include <optional>

namespace sightline {

/// Blocks both signals in the thread that makes it, and so in every thread made after: make it
/// before any other thread. They come back with the object.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  enum class Event { kSignal, kWoken, kTimeout };
  /// Waits for the next signal, wake(), or the end of `timeout` (empty: for ever).
  Event wait(std::optional<std::chrono::milliseconds> timeout);
  /// Ends every wait, now and later. From any thread.
  void wake();

 private:
  sigset_t before_{};
  int signals_ = -1;  ///< a signalfd
  int woken_ = -1;    ///< an eventfd
};

}  // namespace sightline
