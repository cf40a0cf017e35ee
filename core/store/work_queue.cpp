#include "core/store/work_queue.h"

#include <algorithm>
#include <utility>

#include "core/base/priority.h"

namespace sightline {

WorkQueue::WorkQueue(int threads) {
  for (int i = 0; i < std::max(threads, 1); ++i) {
    threads_.emplace_back([this] { work(); });
  }
}

WorkQueue::~WorkQueue() {
  {
    const std::lock_guard hold(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkQueue::push(Lane lane, std::function<void()> job) {
  {
    const std::lock_guard hold(mutex_);
    lanes_[static_cast<std::size_t>(lane)].push_back(std::move(job));
  }
  changed_.notify_one();
}

void WorkQueue::work() {
  lower_priority();  // requests go first
  for (;;) {
    std::function<void()> job;
    {
      std::unique_lock hold(mutex_);
      changed_.wait(hold, [&] { return stopping_ || !lanes_[0].empty() || !lanes_[1].empty(); });
      if (stopping_) return;
      std::deque<std::function<void()>>& lane = lanes_[lanes_[turn_].empty() ? 1 - turn_ : turn_];
      turn_ = 1 - turn_;
      job = std::move(lane.front());
      lane.pop_front();
    }
    job();
  }
}

}  // namespace sightline
