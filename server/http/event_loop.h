#pragma once
/// The event loop: one thread holds every connection that needs no worker now.
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
/// the handler first. A handler that wants the body puts the request off. The event loop then
/// receives the body, to a temporary file where it is long, and a worker calls the handler again.
/// The part of an answer that a client does not take waits in the same way. Streams have threads of
/// their own, which wait for their clients.

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#include "core/base/places.h"
#include "server/http/answer_headers.h"
#include "server/http/connection.h"
#include "server/http/http_limits.h"
#include "server/http/worker_pool.h"

struct epoll_event;

namespace sightline {

/// Counters of the event loop; each may be read at any time.
struct EventLoopCounts {
  std::atomic<std::uint64_t> accepted{0}, open{0}, evicted{0}, timed_out{0}, gone{0};
  std::atomic<std::uint64_t> refused{0};     ///< faults of framing
  std::atomic<std::uint64_t> locked_out{0};  ///< without a key that may
  std::atomic<std::uint64_t> overload{0};    ///< 503, because a queue was full
  std::atomic<std::uint64_t> answered{0};    ///< by the event loop, without a worker
};

/// Estimate of the cost of a request from its head and body. It decides which thread answers.
enum class Weight {
  kInline,  ///< the event loop tries to answer it: that takes no longer than a hand-over to a worker
  kShort,   ///< it needs little, and goes first
  kBulk,
  kLong,  ///< whatever its parameters
};
/// So few bytes of a body are a short request, where nobody judges better.
inline constexpr std::size_t kLittleBody = 2 << 10;

/// Callbacks of the event loop, on its own thread. None of them may wait.
struct EventLoopCallbacks {
  AnswerHeaders headers = {};
  /// Whether a request may come in, by its head alone; null: each.
  std::function<std::optional<RequestFault>(RequestHead&)> admit = {};
  /// Judges a request by its head and by all of its body, if the event loop has it. Null: by the
  /// size of the body.
  std::function<Weight(const RequestHead&, std::string_view body)> weigh = {};
  IsSecret is_secret = {};
  /// Set while the event loop has work; may be null.
  std::atomic<bool>* awake = nullptr;
  /// Called for each request that the event loop refuses; may be null.
  std::function<void(const RequestHead&, const RequestFault&, const std::string& request_id)>
      refused = {};
};

class EventLoop {
 public:
  /// Called on a worker with a request's head in `connection.head`. Takes the body, appends the
  /// answer to the output, and says by `keep` and `skip` how it goes on. It may say `put_off`
  /// instead, and is then called again.
  using Answer = std::function<void(Connection&)>;
  /// `limits`, `memory` and `spool` outlive this.
  EventLoop(const HttpLimits& limits, MemoryBudget& memory, Spool& spool, Answer answer,
            EventLoopCallbacks rules = {});
  ~EventLoop();

  /// Serves a listening socket until stop, and returns when the last connection has ended.
  void run(int listener);
  /// No new connections; idle ones end, requests that have begun are answered. From any thread.
  void stop();
  /// Breaks every connection off, and tells the work for it. After stop, from any thread.
  void break_off();

  const EventLoopCallbacks& rules() const { return rules_; }
  const EventLoopCounts& counts() const { return counts_; }
  std::size_t queued() const {
    return ready_workers_->queued() + bulk_workers_->queued() + long_workers_->queued() +
           stream_workers_->queued();
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// A client that has closed its side may still wait for the answer, or be gone: its work may go
  /// on for so long.
  static constexpr std::chrono::milliseconds kHalfClosed{1000};
  using Phase = Connection::Phase;
  using Heard = Connection::Heard;

  void wake();
  /// Sets the events of the socket that wake the event loop. The owner of the connection calls it.
  void hear(Connection& connection, Heard heard);
  void answer(Connection& connection);
  void give_back(Connection& connection);
  int wait(epoll_event* events, int count);
  void on_event(int socket, std::uint32_t events);
  void take_returned();
  void accept_all(int listener);
  void adopt(int socket);
  /// Closes some of those that have been idle the longest, but never `spared`.
  bool make_room(const Connection* spared);
  void begin_stop(int listener);

  /// Advances a connection of the event loop as far as possible without waiting.
  void advance(Connection& connection);
  /// Where memory runs out for one connection, that one ends.
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
  /// After a handler has put its request off.
  void go_on(Connection& connection);
  /// It gets its next turn after all others.
  void go_on_later(const Connection& connection) { later_.push_back(connection.socket); }
  /// Ends connections that hold much of the spool and are slower than the busy rate.
  void free_spool(const Connection& spared);
  bool advance_sending(Connection& connection);
  void advance_lingering(Connection& connection);
  void await_head(Connection& connection);
  void admit(Connection& connection);
  Weight weight_of(const Connection& connection, std::size_t length) const;
  WorkerPool& workers_for(const Connection& connection, std::size_t length);
  void hand_over(Connection& connection, WorkerPool& workers);
  void begin_sending(Connection& connection);
  /// Tells its pace what the client has taken since.
  void note_taken(Connection& connection);
  /// False where a worker has to answer.
  bool answer_here(Connection& connection, std::size_t length);
  /// Whether the event loop may try to answer one more request in this turn.
  bool has_time_for(Connection& connection) const;
  void refuse(Connection& connection, const RequestFault& fault);
  void refuse_queued(Connection& connection);  ///< which has no worker
  void linger(Connection& connection);
  void close(Connection& connection);
  void reset(Connection& connection);  ///< of a client that does not take its answer
  void check_times();
  void on_late(Connection& connection);

  const HttpLimits& limits_;
  MemoryBudget& budget_;
  Spool& spool_;
  const Answer answer_;
  const EventLoopCallbacks rules_;
  EventLoopCounts counts_;
  int epoll_ = -1, wake_ = -1;
  std::vector<std::unique_ptr<Connection>> connections_;  ///< by socket
  std::vector<int> later_;  ///< sockets of connections that have more to do now
  std::size_t open_ = 0;
  bool accepting_ = true;
  Clock::time_point now_{}, next_check_{};
  std::uint64_t turns_ = 0;
  int answered_here_ = 0, slow_here_ = 0;  ///< in this turn of the loop, of all connections
  const unsigned processors_ = std::thread::hardware_concurrency();

  std::mutex mutex_;  ///< of the next three
  Connection* returned_ = nullptr;
  bool urgent_ = false;  ///< whether any of them needs the event loop now
  bool asleep_ = false;
  std::atomic<bool> stopping_{false}, breaking_{false};
  // Last: their threads end before anything of the above.
  std::unique_ptr<WorkerPool> ready_workers_, bulk_workers_, long_workers_, stream_workers_;
};

}  // namespace sightline
