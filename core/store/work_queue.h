#pragma once
/// WorkQueue: a few threads that run jobs one after the other.

#include <array>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sightline {

/// Threads of lower priority with a queue of two lanes, without a limit of its length. Thread-safe.
class WorkQueue {
 public:
  /// If both lanes have jobs, they alternate, so that neither the loads at start nor many requests
  /// delay the others.
  enum class Lane { kRequest, kStart };

  /// Starts `threads` threads, at least one. Throws std::system_error.
  explicit WorkQueue(int threads);
  /// Waits for running jobs; drops the others.
  ~WorkQueue();
  WorkQueue(const WorkQueue&) = delete;
  WorkQueue& operator=(const WorkQueue&) = delete;

  /// Appends a job, which must not throw. Throws std::bad_alloc, and then queues nothing.
  void push(Lane lane, std::function<void()> job);

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::array<std::deque<std::function<void()>>, 2> lanes_;
  std::size_t turn_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_store_test.cpp
