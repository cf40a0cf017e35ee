#include "server/http/worker_pool.h"

#include <utility>

#include "core/base/priority.h"
#include "server/http/connection.h"

namespace sightline {

WorkerPool::WorkerPool(std::size_t threads, std::size_t queue, Priority priority, Work work)
    : count_(threads), limit_(queue), priority_(priority), work_(std::move(work)) {
  threads_.reserve(threads);
  try {
    for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
  } catch (...) {
    end();
    throw;
  }
}

WorkerPool::~WorkerPool() { end(); }

void WorkerPool::end() {
  {
    const std::lock_guard hold(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

bool WorkerPool::submit(Connection& connection) {
  bool wakes = false;
  {
    const std::lock_guard hold(mutex_);
    // Who finds a worker free does not wait, and so does not count.
    if (queued_ + working_ >= limit_ + count_) return false;
    connection.next = nullptr;
    (first_ == nullptr ? first_ : last_->next) = &connection;
    last_ = &connection;
    ++queued_;
    wakes = should_wake();
  }
  if (wakes) wake_.notify_one();
  return true;
}

bool WorkerPool::should_wake() {
  if (first_ == nullptr || sleeping_ == 0 || waking_) return false;
  waking_ = true;
  return true;
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard hold(mutex_);
  return queued_;
}

bool WorkerPool::has_idle() const {
  const std::lock_guard hold(mutex_);
  return queued_ < sleeping_;
}

void WorkerPool::run() {
  if (priority_ == Priority::kLower) lower_priority();
  // The first allocation of a thread may take the addresses of a whole heap (64 MiB in glibc):
  // better now than when memory is short. Volatile, because it would be left out else.
  char* volatile first = new char[64];
  delete[] first;
  std::unique_lock hold(mutex_);
  for (;;) {
    while (first_ == nullptr && !ending_) {
      ++sleeping_;
      wake_.wait(hold);
      --sleeping_;
      waking_ = false;
    }
    if (first_ == nullptr) return;
    Connection* connection = first_;
    first_ = connection->next;
    --queued_;
    ++working_;
    const bool wakes = should_wake();
    hold.unlock();
    if (wakes) wake_.notify_one();
    work_(*connection);
    hold.lock();
    --working_;
  }
}

}  // namespace sightline
