#pragma once
/// WorkerPool: threads that answer requests, with a bounded queue.

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

/// Answers the requests of connections on its threads. Construct, then submit() connections; each
/// is answered on a worker and then given back.
///
/// The queue is fair: start-time fair queueing [Goyal1996]. A flow is a connection, or a key if
/// keys are in use. A flow that has used its workers for a second waits until every other waiting
/// flow has used them for a second too. A request that is
/// expected to take a second more than another (Connection::expected) waits as if its flow had had a
/// second more. So a request waits for the requests of other flows that run, and not for all that
/// arrived before it. Slow requests, which are expected to take more than Connection::kUnknown, take
/// a multiple of that beside other load. They use at most half of the threads, but at least one.
class WorkerPool {
 public:
  using Work = std::function<void(Connection&)>;
  /// kLower: the threads get less processor time than others (lower_priority).
  enum class Priority { kNormal, kLower };
  /// Options of a pool.
  struct Options {
    std::size_t threads;
    std::size_t queue;  ///< the most waiting connections, while all threads that may take them work
    Priority priority = Priority::kLower;
    std::size_t number = 0;                   ///< index in Connection::flows; each pool has its own
    std::function<double()> clock = seconds;  ///< measures the cost of a request, in seconds
  };
  /// The steady clock, in seconds.
  static double seconds();

  /// answer     answers a request; called on a worker
  /// give_back  returns the connection to the event loop; called on a worker after `answer`
  /// Neither may throw. Throws std::system_error if the system refuses so many threads.
  WorkerPool(const Options& options, Work answer, Work give_back);
  /// Waits until all queued requests are answered, then ends the threads.
  ~WorkerPool();

  /// Queues a connection, which must live until it is given back. Returns false, and queues
  /// nothing, if the queue is full. Thread-safe.
  bool submit(Connection& connection);
  /// Connections that wait for a thread. Thread-safe.
  std::size_t queued() const;
  /// True if more threads sleep than requests are queued. Thread-safe.
  bool has_idle() const;

 private:
  struct Waiting {
    double start;  ///< virtual time, in seconds of a worker
    double end;    ///< decides the order: start, and what the request is expected to take
    std::uint64_t arrival;
    Connection* connection;
    bool operator<(const Waiting& other) const {  // the first element of a heap is its greatest
      return end != other.end ? end > other.end : arrival > other.arrival;
    }
  };

  /// Waiting requests; a heap. Its memory is allocated by the constructor.
  using Heap = std::vector<Waiting>;

  void run();
  void end();
  /// True if a thread may begin a request of slow_.
  bool may_begin_slow() const;
  /// True if a thread may begin a queued request.
  bool has_next() const;
  /// True if a sleeping thread should be woken: has_next(), threads sleep, and none is being woken.
  bool should_wake();
  /// Brings the next request of a heap to its front. Precondition: the heap is not empty.
  void update_front(Heap& heap);
  /// Removes the next request from the queue. Precondition: has_next().
  Waiting take_next();
  std::size_t queue_size() const { return ordinary_.size() + slow_.size(); }
  /// The virtual time at which the flow of a connection has used up what it was given.
  double& finish_of(Connection& connection);

  const Options options_;
  const Work answer_, give_back_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  Heap ordinary_;
  Heap slow_;       ///< of slow requests
  double now_ = 0;  ///< virtual time: at least the start of each request that has begun
  std::uint64_t arrivals_ = 0;
  std::map<std::string, double, std::less<>> finish_of_key_;
  std::size_t working_ = 0;       ///< number of threads
  std::size_t slow_working_ = 0;  ///< those of them with a request of slow_
  std::size_t sleeping_ = 0;      ///< number of threads
  bool waking_ = false;           ///< a thread was woken and has not run yet
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace sightline
