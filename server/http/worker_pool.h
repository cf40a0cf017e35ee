#pragma once
/// Threads that answer requests, and the bounded queue before them.

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sightline {

struct Connection;

/// Queued connections are taken first come, first served. `work` must not throw.
class WorkerPool {
 public:
  using Work = std::function<void(Connection&)>;
  enum class Priority { kNormal, kLower };
  /// Throws std::system_error where the system gives so many threads to nobody.
  WorkerPool(std::size_t threads, std::size_t queue, Priority priority, Work work);
  /// Ends after what is queued.
  ~WorkerPool();

  /// False when the queue is full.
  bool submit(Connection& connection);
  std::size_t queued() const;
  /// Whether a thread sleeps that is not needed for what is queued already.
  bool has_idle() const;

 private:
  void run();
  void end();
  /// Whether to wake somebody: while a queue stands and there are sleepers, one is being woken.
  bool should_wake();

  const std::size_t count_, limit_;  ///< threads; connections in the queue
  const Priority priority_;
  const Work work_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  Connection* first_ = nullptr;  ///< of the queue
  Connection* last_ = nullptr;
  std::size_t queued_ = 0;
  std::size_t working_ = 0;   ///< threads
  std::size_t sleeping_ = 0;  ///< threads
  bool waking_ = false;       ///< somebody is on the way: nobody else needs to be woken now
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace sightline
