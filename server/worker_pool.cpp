#include "server/worker_pool.h"

#include <utility>

#include "server/connection.h"

namespace sightline {

WorkerPool::WorkerPool(std::size_t threads, std::size_t queue, Work work)
    : limit_(queue), work_(std::move(work)) {
  threads_.reserve(threads);
  for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard hold(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

bool WorkerPool::submit(Connection& connection) {
  {
    const std::lock_guard hold(mutex_);
    // Who finds a worker free does not wait, and so does not count.
    if (queued_ >= limit_ + sleeping_) return false;
    connection.next = nullptr;
    (first_ == nullptr ? first_ : last_->next) = &connection;
    last_ = &connection;
    ++queued_;
  }
  wake_.notify_one();
  return true;
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard hold(mutex_);
  return queued_;
}

void WorkerPool::run() {
  // The first allocation of a thread may take the addresses of a whole heap (64 MiB in glibc):
  // better now than when memory is short. Volatile, because it would be left out else.
  char* volatile first = new char[64];
  delete[] first;
  std::unique_lock hold(mutex_);
  for (;;) {
    ++sleeping_;
    wake_.wait(hold, [this] { return ending_ || first_ != nullptr; });
    --sleeping_;
    if (first_ == nullptr) return;
    Connection* connection = first_;
    first_ = connection->next;
    --queued_;
    hold.unlock();
    work_(*connection);
    hold.lock();
  }
}

}  // namespace sightline
