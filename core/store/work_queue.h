#pragma once
/// A few threads that do one job after the other.

#include <array>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sightline {

class WorkQueue {
 public:
  /// Where both lanes have jobs, they take turns: neither a long start nor many requests delay the
  /// other.
  enum class Lane { kRequest, kStart };

  explicit WorkQueue(int threads);
  /// Waits for the jobs that run; the others are dropped.
  ~WorkQueue();
  WorkQueue(const WorkQueue&) = delete;
  WorkQueue& operator=(const WorkQueue&) = delete;

  /// A job throws nothing.
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
