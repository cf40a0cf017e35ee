#pragma once
/// Threads that answer requests, and the bounded queue before them.

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sightline {

struct Connection;

/// The queue is fair: start-time fair queueing [Goyal1996]. Each connection, or each key where keys are
/// in use, is a flow. A flow that has used its workers for a second waits until every other flow that
/// waits has used them for a second too. So a request waits for those that run, and not for all that
/// came before it. The cost of a request is the time that it takes a worker, so nobody estimates it.
class WorkerPool {
 public:
  using Work = std::function<void(Connection&)>;
  enum class Priority { kNormal, kLower };
  struct Options {
    std::size_t threads;
    std::size_t queue;  ///< connections that wait
    Priority priority = Priority::kLower;
    std::size_t number = 0;                   ///< of Connection::flows, unlike those of other pools
    std::function<double()> clock = seconds;  ///< what measures the cost of a request, in seconds
  };
  /// The steady clock, in seconds.
  static double seconds();

  /// answer     answers a request
  /// give_back  the connection is the caller's again
  /// Neither may throw. Throws std::system_error where the system does not give so many threads.
  WorkerPool(const Options& options, Work answer, Work give_back);
  /// Ends after what is queued.
  ~WorkerPool();

  /// False when the queue is full.
  bool submit(Connection& connection);
  std::size_t queued() const;
  /// Whether a thread sleeps that is not needed for what is queued already.
  bool has_idle() const;

 private:
  struct Waiting {
    double start;  ///< virtual time, in seconds of a worker
    std::uint64_t arrival;
    Connection* connection;
    bool operator<(const Waiting& other) const {  // the heap begins with its greatest
      return start != other.start ? start > other.start : arrival > other.arrival;
    }
  };

  void run();
  void end();
  /// Whether to wake somebody: while a queue stands and there are sleepers, one is being woken.
  bool should_wake();
  /// Precondition: the queue is not empty.
  Waiting take_next();
  /// Virtual time when the flow of a connection has had what it was given so far.
  double& finish_of(Connection& connection);

  const Options options_;
  const Work answer_, give_back_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<Waiting> queue_;  ///< a heap; its memory is there from the beginning
  double now_ = 0;              ///< virtual time: the greatest start of a request that has begun
  std::uint64_t arrivals_ = 0;
  std::map<std::string, double, std::less<>> finish_of_key_;
  std::size_t working_ = 0;   ///< threads
  std::size_t sleeping_ = 0;  ///< threads
  bool waking_ = false;       ///< somebody is on the way: nobody else needs to be woken now
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace sightline
