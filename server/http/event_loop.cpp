#include "server/http/event_loop.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <new>
#include <string>
#include <system_error>
#include <utility>

namespace sightline {
namespace {

constexpr std::chrono::milliseconds kCheck{100};
/// How long a head that has begun may take to end after a stop.
constexpr std::chrono::milliseconds kLastHead{1000};
constexpr int kAcceptedAtOnce = 256;
/// Bytes that the system may hold of an answer beside those that are under way to the client. It would
/// hold up to 4 MiB for each client that does not read.
constexpr int kUnsent = 128 << 10;
/// SO_SNDBUF of connections with large send buffers while the sum of all is too large. The kernel doubles it.
constexpr int kSendBuffer = 64 << 10;

/// sendfile has no MSG_NOSIGNAL. Threads that are started later inherit it.
void block_broken_pipe() {
  sigset_t broken_pipe;
  ::sigemptyset(&broken_pipe);
  ::sigaddset(&broken_pipe, SIGPIPE);
  ::pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);
}

bool watch(int epoll, int socket, std::uint32_t events, int how = EPOLL_CTL_ADD) {
  epoll_event wanted{};
  wanted.events = events;
  wanted.data.fd = socket;
  return ::epoll_ctl(epoll, how, socket, &wanted) == 0;
}

std::uint32_t events_of(Connection::Heard heard) {
  // An edge tells that a client is gone also while its request is at work, and costs nothing there.
  std::uint32_t events = EPOLLRDHUP | EPOLLET;
  if (heard != Connection::Heard::kEnd) events |= EPOLLIN;
  if (heard == Connection::Heard::kRoom) events |= EPOLLOUT;
  return events;
}

/// Of a request that has come in: a worker's output is not read.
bool owes_answer(const Connection& connection) {
  using Phase = Connection::Phase;
  return connection.phase == Phase::kBody || connection.phase == Phase::kAtWork ||
         (connection.phase == Phase::kSending && connection.has_output());
}

}  // namespace

EventLoop::EventLoop(const HttpLimits& limits, MemoryBudget& memory, Spool& spool, Answer answer,
                     EventLoopCallbacks rules)
    : limits_(limits),
      budget_(memory),
      spool_(spool),
      answer_(std::move(answer)),
      rules_(std::move(rules)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  watch(epoll_, wake_, EPOLLIN | EPOLLET);
}

EventLoop::~EventLoop() {
  for (auto& connection : connections_) {
    if (connection) ::close(connection->socket);
  }
  ::close(epoll_);
  ::close(wake_);
}

void EventLoop::wake() {
  const std::uint64_t one = 1;
  (void)!::write(wake_, &one, sizeof one);
}

void EventLoop::stop() {
  stopping_ = true;
  wake();
}

void EventLoop::break_off() {
  stopping_ = true;
  breaking_ = true;
  wake();
}

void EventLoop::hear(Connection& connection, Heard heard) {
  if (connection.heard == heard) return;
  connection.heard = heard;
  // What is there already is told at once.
  watch(epoll_, connection.socket, events_of(heard), EPOLL_CTL_MOD);
}

void EventLoop::answer(Connection& connection) {
  try {
    answer_(connection);
  } catch (...) {
    // Memory ran out where nobody could answer any more.
    connection.keep = false;
    connection.broken = true;
    connection.put_off =
        connection.on_event_loop ? Connection::PutOff::kToWorker : Connection::PutOff::kNo;
  }
}

void EventLoop::give_back(Connection& connection) {
  if (connection.heard == Heard::kEnd) hear(connection, Heard::kBytes);
  // A connection that only waits for its next request does not wake the event loop: the request
  // does. If that has come meanwhile, the event loop has seen a connection at work and marked it.
  const bool is_quiet = connection.put_off == Connection::PutOff::kNo && connection.keep &&
                        !connection.broken && connection.skip == 0 && connection.charged == 0 &&
                        !connection.body && !connection.has_output() &&
                        connection.pending_input().empty();
  bool was_asleep = false;
  {
    const std::lock_guard hold(mutex_);
    connection.next = returned_;
    returned_ = &connection;
    if (!is_quiet || connection.stirred) {
      urgent_ = true;
      was_asleep = std::exchange(asleep_, false);
    }
  }
  if (was_asleep) wake();
}

int EventLoop::wait(epoll_event* events, int count) {
  // The last check of times, after the last connection has ended, finds the send buffers empty.
  const bool checks = open_ > 0 || counts_.send_buffers > 0 || !accepting_;
  int timeout_ms = checks ? static_cast<int>(kCheck.count()) : -1;
  {
    const std::lock_guard hold(mutex_);
    asleep_ = !urgent_ && later_.empty();
    if (!asleep_) timeout_ms = 0;
  }
  if (rules_.awake != nullptr) rules_.awake->store(false, std::memory_order_relaxed);
  const int ready = ::epoll_wait(epoll_, events, count, timeout_ms);
  if (rules_.awake != nullptr) rules_.awake->store(true, std::memory_order_relaxed);
  {
    const std::lock_guard hold(mutex_);
    asleep_ = false;
  }
  now_ = Clock::now();
  answered_here_ = slow_here_ = 0;
  return std::max(ready, 0);
}

Status EventLoop::start() try {
  block_broken_pipe();
  const auto start = [this](std::unique_ptr<WorkerPool>& pool, const WorkerPool::Options& options) {
    pool = std::make_unique<WorkerPool>(
        options, [this](Connection& connection) { answer(connection); },
        [this](Connection& connection) { give_back(connection); });
  };
  const std::size_t workers = limits_.workers;
  start(ready_workers_, {workers, limits_.queue, WorkerPool::Priority::kNormal, 0});
  // Many numbers to read and to write take long: small requests do not wait for that.
  start(bulk_workers_, {workers, limits_.queue, WorkerPool::Priority::kLower, 1});
  // Few, so that a short request beside them waits for few. Those waiting do not hold it up.
  start(long_workers_,
        {std::max<std::size_t>(2, workers / 4), limits_.queue, WorkerPool::Priority::kLower, 2});
  start(stream_workers_, {limits_.streams, 0, WorkerPool::Priority::kLower, 3});
  return success();
} catch (const std::system_error& error) {
  return Error{ErrorKind::kInternal, "THREADS_FEW",
               "the system does not give the threads of " + std::to_string(limits_.workers) +
                   " workers and " + std::to_string(limits_.streams) +
                   " streams: " + error.code().message(),
               ""};
}

void EventLoop::run(int listener) {
  block_broken_pipe();
  watch(epoll_, listener, EPOLLIN);
  bool stopped = false;
  std::array<epoll_event, 256> events;
  while (!stopped || open_ > 0) {
    const int count = wait(events.data(), static_cast<int>(events.size()));
    bool has_newcomers = false;
    for (int i = 0; i < count; ++i) {
      const int socket = events[static_cast<std::size_t>(i)].data.fd;
      if (socket == listener) {
        has_newcomers = true;
      } else if (socket == wake_) {
        // Edge-triggered: it need not be read.
      } else {
        on_event(socket, events[static_cast<std::size_t>(i)].events);
      }
    }
    take_returned();
    for (const int socket : std::exchange(later_, {})) {
      if (connections_[static_cast<std::size_t>(socket)]) {
        Connection& connection = *connections_[static_cast<std::size_t>(socket)];
        guard(connection, [&] { advance(connection); });
      }
    }
    // After all events: a new connection may get the number of one that was just closed.
    if (has_newcomers && !stopped) accept_all(listener);
    if (stopping_ && !std::exchange(stopped, true)) begin_stop(listener);
    if (now_ >= next_check_) {
      check_times();
      if (!accepting_ && !stopped) accepting_ = watch(epoll_, listener, EPOLLIN);
      next_check_ = now_ + kCheck;
    }
  }
  ready_workers_.reset();
  bulk_workers_.reset();
  long_workers_.reset();
  stream_workers_.reset();
}

void EventLoop::on_event(int socket, std::uint32_t events) {
  const auto at = static_cast<std::size_t>(socket);
  if (at >= connections_.size() || !connections_[at]) return;
  Connection& connection = *connections_[at];
  if ((events & (EPOLLIN | EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0) connection.readable = true;
  if ((events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0 && !connection.ended) {
    connection.ended = true;
    connection.ended_at = now_;
  }
  if ((events & (EPOLLHUP | EPOLLERR)) != 0 && !connection.gone.cancelled()) {
    connection.gone.cancel();
    // A client that closes a connection after the whole answer is not missed.
    if (owes_answer(connection)) ++counts_.gone;
  }
  connection.stirred = true;
  connection.answered_here = 0;
  guard(connection, [&] { advance(connection); });
}

void EventLoop::take_returned() {
  Connection* returned = nullptr;
  {
    const std::lock_guard hold(mutex_);
    returned = std::exchange(returned_, nullptr);
    urgent_ = false;
  }
  while (Connection* connection = returned) {
    returned = connection->next;
    if (connection->put_off != Connection::PutOff::kNo) {
      guard(*connection, [&] {
        go_on(*connection);
        advance(*connection);
      });
      continue;
    }
    if (connection->broken) {
      reset(*connection);
      continue;
    }
    connection->forget_body();
    begin_sending(*connection);
    guard(*connection, [&] { advance(*connection); });
  }
}

void EventLoop::accept_all(int listener) {
  for (int i = 0; i < kAcceptedAtOnce || stopping_; ++i) {
    const int socket = ::accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket >= 0) {
      try {
        adopt(socket);
      } catch (const std::bad_alloc&) {
        ::close(socket);
      }
      continue;
    }
    if (errno == EINTR || errno == ECONNABORTED) continue;
    if (errno == EAGAIN || errno == EWOULDBLOCK) return;
    // Descriptors or memory have run out, which is told also where nobody waits to be accepted.
    pollfd waiting{listener, POLLIN, 0};
    if (::poll(&waiting, 1, 0) == 0) return;
    // Without room it is tried again later: the listener stays readable, and asking it would be all
    // that this thread does.
    if (make_room(nullptr)) continue;
    ::epoll_ctl(epoll_, EPOLL_CTL_DEL, listener, nullptr);
    accepting_ = false;
    return;
  }
}

void EventLoop::adopt(int socket) {
  ++counts_.accepted;
  const int yes = 1;
  // Without it an answer may wait 40 ms for the client's acknowledgement.
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  ::setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsent, sizeof kUnsent);
  const auto at = static_cast<std::size_t>(socket);
  if (at >= connections_.size()) connections_.resize(at + 1);
  connections_[at] = std::make_unique<Connection>(socket, budget_, spool_);
  Connection& connection = *connections_[at];
  ++open_;
  counts_.open = open_;
  if (!watch(epoll_, socket, events_of(connection.heard))) return close(connection);
  await_head(connection);
  if (open_ > limits_.connections && !make_room(&connection)) {
    return guard(connection, [&] {
      refuse(connection,
             {503, "CONNECTIONS_FULL", "the server holds as many connections as it may"});
      advance(connection);
    });
  }
  guard(connection, [&] { advance(connection); });
}

bool EventLoop::make_room(const Connection* spared) try {
  std::vector<Connection*> idle;
  for (const auto& connection : connections_) {
    if (!connection || connection.get() == spared) continue;
    if (connection->phase == Phase::kHead || connection->phase == Phase::kLingering) {
      idle.push_back(connection.get());
    }
  }
  if (idle.empty()) return false;
  // A few at a time, so that a flood does not search each time.
  const std::size_t count = std::max<std::size_t>(1, idle.size() / 32);
  std::nth_element(
      idle.begin(), idle.begin() + static_cast<std::ptrdiff_t>(count - 1), idle.end(),
      [](const Connection* a, const Connection* b) { return a->idle_turn < b->idle_turn; });
  for (std::size_t i = 0; i < count; ++i) close(*idle[i]);
  counts_.evicted += count;
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

void EventLoop::begin_stop(int listener) {
  // The client of a connection in the queue of the kernel takes it for accepted.
  accept_all(listener);
  ::epoll_ctl(epoll_, EPOLL_CTL_DEL, listener, nullptr);
  ::shutdown(listener, SHUT_RDWR);
  for (const auto& connection : connections_) {
    if (!connection || connection->phase != Phase::kHead) continue;
    connection->due = std::min(connection->due, now_ + kLastHead);
    connection->readable = true;
    guard(*connection, [&] { advance(*connection); });
  }
}

void EventLoop::close(Connection& connection) {
  const int socket = connection.socket;
  ::close(socket);
  connections_[static_cast<std::size_t>(socket)].reset();
  --open_;
  counts_.open = open_;
}

void EventLoop::reset(Connection& connection) {
  // A client that is gone is counted as gone.
  if (!connection.gone.cancelled()) ++counts_.timed_out;
  // Else the kernel would go on with what it has taken of the answer.
  const struct linger hard { 1, 0 };
  ::setsockopt(connection.socket, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
  close(connection);
}

void EventLoop::limit_send_buffers() {
  const bool is_much = counts_.send_buffers > budget_.all() / 4;
  std::uint64_t sum = 0;
  for (const auto& slot : connections_) {
    if (!slot) continue;
    Connection& connection = *slot;
    // A worker may write `given` now; only streams stay with one for long.
    const bool has_worker = connection.phase == Phase::kAtWork;
    if (has_worker ? !connection.streams : connection.acknowledged == connection.given) continue;
    const std::uint64_t bytes = send_buffer_bytes(connection);
    if (!has_worker) connection.acknowledged = connection.given - std::min(connection.given, bytes);
    sum += bytes;
    // A fixed size ends the growth. What is in the buffer stays until the client acknowledges it.
    if (is_much && bytes > kSendBuffer) {
      ::setsockopt(connection.socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
    }
  }
  counts_.send_buffers = sum;
}

void EventLoop::check_times() {
  limit_send_buffers();
  const bool breaking = breaking_;
  for (const auto& slot : connections_) {
    if (!slot) continue;
    Connection& connection = *slot;
    if (breaking) {
      connection.gone.cancel();
      ::shutdown(connection.socket, SHUT_RDWR);
    }
    if (connection.phase == Phase::kAtWork) {
      const auto patience = std::max(connection.ended_at + kHalfClosed, connection.due);
      if (connection.ended && now_ >= patience && !connection.gone.cancelled()) {
        connection.gone.cancel();
        ++counts_.gone;
      }
    } else if (breaking) {
      close(connection);
    } else if (now_ >= connection.due) {
      guard(connection, [&] { on_late(connection); });
    } else if (connection.phase == Phase::kBody && connection.kept) {
      guard(connection, [&] { advance(connection); });
    }
  }
}

}  // namespace sightline
