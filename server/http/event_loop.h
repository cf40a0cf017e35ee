#pragma once
/// EventLoop: one thread that owns every connection that is not with a worker.
///
///            bytes            head and body whole, or body long
///   accept ---------> kHead ------> kBody ------------------> kAtWork (queue, then a worker)
///                       ^             refused: a short answer, then kLingering
///                       |                                        |
///                       +----------- kSending <------------------+  what the client has not taken
///                                        | the connection ends
///                                        +--> kLingering --> closed
///
/// A worker never waits for a client. The event loop receives a body of up to 64 KiB before a
/// worker takes the request. For a longer body, a chunked one and one with Expect, a worker calls
/// the handler first. If the handler wants the body, it puts the request off. The event loop then
/// receives the body, a long one into a temporary file, and a worker calls the handler again. The
/// event loop also sends the part of an answer that a client does not take at once. Streams have
/// threads of their own, which wait for their clients. In kLingering the event loop drops what the
/// client still sends, for a second at most; an immediate close could lose the answer.

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#include "server/http/answer_headers.h"
#include "server/http/connection.h"
#include "server/http/http_limits.h"
#include "server/http/worker_pool.h"

struct epoll_event;

namespace sightline {

/// Counters of the event loop. Each may be read at any time, on any thread.
struct EventLoopCounts {
  /// Connections: accepted; open now; closed while idle, to make room; ended because the client was
  /// too slow; ended by the client before its answer.
  std::atomic<std::uint64_t> accepted{0}, open{0}, evicted{0}, timed_out{0}, gone{0};
  /// requests refused before a handler, with another status below 500 than 401, 403 and 408
  std::atomic<std::uint64_t> refused{0};
  std::atomic<std::uint64_t> locked_out{0};  ///< requests refused with 401 or 403
  std::atomic<std::uint64_t> overload{0};    ///< answered with 503 because a queue was full
  std::atomic<std::uint64_t> answered{0};    ///< requests that the event loop answered itself
  /// bytes of answers in the send buffers of the kernel, counted every 100 ms
  std::atomic<std::uint64_t> send_buffers{0};
};

/// The estimated cost of a request, from its head and body. It decides which thread answers.
enum class Weight {
  /// the event loop tries to answer it, which takes no longer than passing it to a worker
  kInline,
  kShort,  ///< needs little time, and takes precedence
  kBulk,   ///< its cost depends on its size, and short requests do not wait for it
};
/// Without an estimate, a request with at most so many bytes of body is kShort, others are kBulk.
inline constexpr std::size_t kLittleBody = 2 << 10;

/// Callbacks of the event loop, called on its thread. They must not wait. `is_secret` is also
/// called on workers, so it must be thread-safe.
struct EventLoopCallbacks {
  AnswerHeaders headers = {};  ///< writes the headers of all answers
  /// Checks a request by its head, in which it may set the members about the client. A fault
  /// refuses the request. Null: all are accepted.
  std::function<std::optional<RequestFault>(RequestHead&)> admit = {};
  /// Estimates a request from its head, and from its body if all of it is with the event loop.
  /// Null: by the size of the body.
  std::function<Weight(const RequestHead&, std::string_view body)> weigh = {};
  IsSecret is_secret = {};  ///< true for request ids that are replaced; null: none
  /// Set to true while the event loop works, to false while it waits. Null: not used. Must outlive
  /// the event loop.
  std::atomic<bool>* awake = nullptr;
  /// Called for each request that the event loop refuses. May be null.
  std::function<void(const RequestHead&, const RequestFault&, const std::string& request_id)>
      refused = {};
};

/// Receives requests and passes them to workers. Construct, start(), then run() on one thread;
/// stop() on another thread ends run(). The destructor closes all connections; run() must have
/// returned.
class EventLoop {
 public:
  /// Called on a worker, or on the event loop if `connection.on_event_loop`, with a request in
  /// `connection.head`. Reads the body, appends the answer to the output, and sets `keep` and
  /// `skip` for what follows. It may set `put_off` instead, and is then called again. An exception
  /// ends the connection.
  using Answer = std::function<void(Connection&)>;
  /// `limits`, `memory` and `spool` must outlive the event loop.
  EventLoop(const HttpLimits& limits, MemoryBudget& memory, Spool& spool, Answer answer,
            EventLoopCallbacks rules = {});
  ~EventLoop();

  /// Starts the threads of workers and streams. Errors: THREADS_FEW, after which run() must not be
  /// called.
  Status start();
  /// Serves a listening socket until stop(), and returns when the last connection has ended and all
  /// workers have ended. Called once, after start(). Does not close `listener`.
  void run(int listener);
  /// Stops accepting; idle connections are closed, requests that have begun are answered.
  /// Thread-safe.
  void stop();
  /// Stops, closes every connection and cancels its work, within 100 ms. Thread-safe.
  void break_off();

  const EventLoopCallbacks& rules() const { return rules_; }
  const EventLoopCounts& counts() const { return counts_; }
  /// Requests that wait for a worker. Thread-safe, from start() until run() returns.
  std::size_t queued() const {
    return ready_workers_->queued() + bulk_workers_->queued() + long_workers_->queued() +
           stream_workers_->queued();
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// If a client closes its side, it may be waiting for the answer or be gone. Its work continues
  /// for so long.
  static constexpr std::chrono::milliseconds kHalfClosed{1000};
  using Phase = Connection::Phase;
  using Heard = Connection::Heard;

  void wake();
  /// Sets the events of the socket that wake the event loop. Called by the owner of the connection.
  void hear(Connection& connection, Heard heard);
  void answer(Connection& connection);
  void give_back(Connection& connection);
  int wait(epoll_event* events, int count);
  void on_event(int socket, std::uint32_t events);
  void take_returned();
  void accept_all(int listener);
  void adopt(int socket);
  /// Closes some of the connections that have been idle longest, but not `spared`.
  bool make_room(const Connection* spared);
  void begin_stop(int listener);

  /// Advances a connection as far as possible without waiting.
  void advance(Connection& connection);
  /// Runs step(); if memory runs out, closes the connection.
  template <class Step>
  void guard(Connection& connection, const Step& step) {
    const auto at = static_cast<std::size_t>(connection.socket);
    try {
      step();
    } catch (const std::bad_alloc&) {
      if (connections_[at]) close(*connections_[at]);
    }
  }
  bool advance_head(Connection& connection);
  bool advance_body(Connection& connection);
  bool advance_gathered(Connection& connection);
  bool advance_stored(Connection& connection);
  void begin_body(Connection& connection);
  /// Continues after a handler has put its request off.
  void go_on(Connection& connection);
  /// Gives a connection its next turn after all others.
  void go_on_later(const Connection& connection) { later_.push_back(connection.socket); }
  /// Called when a file does not fit into the spool. Ends all connections, except `spared`, that hold
  /// more than a small part of it (`is_small` of the spool) and are slower than HttpLimits::busy_rate.
  void free_spool(const Connection& spared);
  bool advance_sending(Connection& connection);
  void advance_lingering(Connection& connection);
  void await_head(Connection& connection);
  void admit(Connection& connection);
  Weight weight_of(const Connection& connection, std::size_t length) const;
  WorkerPool& workers_for(Connection& connection, std::size_t length);
  void hand_over(Connection& connection, WorkerPool& workers);
  void begin_sending(Connection& connection);
  /// Updates the connection's pace by what the client has acknowledged since.
  void note_taken(Connection& connection);
  /// Tries to answer on the event loop. Returns false if a worker must answer.
  bool answer_here(Connection& connection, std::size_t length);
  /// True if the event loop may try to answer one more request in this turn.
  bool has_time_for(Connection& connection) const;
  void refuse(Connection& connection, const RequestFault& fault);
  void refuse_queued(Connection& connection);  ///< answers 503: the queue is full
  void linger(Connection& connection);
  void close(Connection& connection);
  /// closes a connection whose client does not take its answer
  void reset(Connection& connection);
  void check_times();
  /// Counts the bytes in the send buffers of the kernel. Beyond a quarter of the memory, large
  /// buffers stop growing.
  void limit_send_buffers();
  void on_late(Connection& connection);

  const HttpLimits& limits_;
  MemoryBudget& budget_;
  Spool& spool_;
  const Answer answer_;
  const EventLoopCallbacks rules_;
  EventLoopCounts counts_;
  int epoll_ = -1, wake_ = -1;
  std::vector<std::unique_ptr<Connection>> connections_;  ///< indexed by socket
  std::vector<int> later_;  ///< sockets of connections that can be advanced further
  std::size_t open_ = 0;
  bool accepting_ = true;
  Clock::time_point now_{}, next_check_{};
  std::uint64_t turns_ = 0;
  int answered_here_ = 0, slow_here_ = 0;  ///< counts of all connections in this turn of the loop
  const unsigned processors_ = std::thread::hardware_concurrency();

  std::mutex mutex_;  ///< protects the next three members
  Connection* returned_ = nullptr;
  bool urgent_ = false;  ///< a returned connection needs the event loop now
  bool asleep_ = false;
  std::atomic<bool> stopping_{false}, breaking_{false};
  // Last, because their threads use the members above.
  std::unique_ptr<WorkerPool> ready_workers_, bulk_workers_, long_workers_, stream_workers_;
};

}  // namespace sightline
