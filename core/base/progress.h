#pragma once
/// Progress of a long piece of work. Its worker thread reports; other threads read, and may cancel
/// it.

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>

#include "core/base/deadline.h"

namespace sightline {

/// One thread at a time reports with begin() and reach(); any thread may read and cancel.
class Progress {
 public:
  /// The progress at one moment.
  struct Reading {
    const char* stage = "";  ///< a literal; "" before the first stage
    /// progress within the stage, 0 to 100; empty if its total is not known
    std::optional<int> percent;
  };

  /// Starts a stage. `stage` must be a literal. `total` is the value of reach() at the end of the
  /// stage; 0: not known.
  void begin(const char* stage, std::uint64_t total = 0) {
    const std::lock_guard hold(mutex_);
    stage_ = stage;
    total_ = total;
    done_.store(0, std::memory_order_relaxed);
  }
  /// Sets how much of the stage's total is done. Cheap enough for an inner loop.
  void reach(std::uint64_t done) { done_.store(done, std::memory_order_relaxed); }
  /// The present progress. Thread-safe.
  Reading reading() const {
    const std::lock_guard hold(mutex_);
    if (total_ == 0) return {stage_, std::nullopt};
    const std::uint64_t done = std::min(done_.load(std::memory_order_relaxed), total_);
    return {stage_,
            static_cast<int>(100.0 * static_cast<double>(done) / static_cast<double>(total_))};
  }

  /// Asks the worker to stop. The worker may finish before it notices. Thread-safe.
  void cancel() { flag_.cancel(); }
  bool cancelled() const { return flag_.cancelled(); }
  /// The flag that cancel() sets; valid while this object lives.
  const CancelFlag& flag() const { return flag_; }

 private:
  mutable std::mutex mutex_;
  const char* stage_ = "";
  std::uint64_t total_ = 0;
  std::atomic<std::uint64_t> done_{0};
  CancelFlag flag_;
};

}  // namespace sightline

// Tests: tests/unit/server/progress_bar_test.cpp
