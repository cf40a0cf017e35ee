/// What EventLoop does with a connection in each of its phases.

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <utility>

#include "server/http/event_loop.h"
#include "server/http/exchange.h"
#include "server/http/response_writer.h"

namespace sightline {
namespace {

/// A longer body is put to a temporary file.
constexpr std::uint64_t kGathered = 64 << 10;
/// A request with a longer body is a long one.
constexpr std::uint64_t kLongBody = 1 << 20;
/// Bytes of a long body for each unit of cost: those of a ray in binary.
constexpr std::uint64_t kBytesOfCost = 48;
/// Bytes that one connection receives or sends before others have their turn.
constexpr std::uint64_t kInOneTurn = 256 << 10;
/// How soon a handler that takes its body in parts is told of a part that is not whole.
constexpr std::chrono::milliseconds kPart{100};
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
/// How much of what a client still sends is taken in before a close, and for how long: closing over
/// unread bytes would reset the connection, and the client would lose the answer.
constexpr std::size_t kLingerBytes = 1 << 20;
constexpr std::chrono::milliseconds kLinger{1000};
/// Bytes of an incomplete head and of a body that every connection may hold, whatever others hold.
constexpr std::uint64_t kFreeHead = 4 << 10, kFreeBody = 4 << 10;
/// Capacity of the string that receives heads. With its terminator it takes kFreeHead.
constexpr std::size_t kReceived = kFreeHead - 1;
/// Answers to pipelined requests of one connection before other connections get their turn.
constexpr int kAnsweredHere = 16;
/// Limits of one turn of the loop: answers of all connections, and slow ones among them. One alone
/// may have been slow because the thread was preempted.
constexpr int kAnsweredInTurn = 64, kSlowInTurn = 4;
constexpr std::chrono::microseconds kSlow{50};
/// Requests of a connection that go to workers untried after one that took too long here.
constexpr int kNotTried = 64;

/// Whether to try again: an end that was reported with the last bytes is reported by no new edge.
void note(Connection& connection, Received received) {
  connection.readable =
      received == Received::kSome || (received == Received::kAll && connection.ended);
}

RequestFault spool_busy() {
  return {503, "SPOOL_BUSY",
          "the disk space for bodies and answers on their way is in use: try again later"};
}

/// Whether the client's head may wait for its rest: thousands may have begun long ones.
bool charge_head(Connection& connection) {
  const std::uint64_t held = connection.input.capacity();
  if (held < kFreeHead || held <= connection.charged) return true;
  if (!connection.budget.charge(held - connection.charged)) return false;
  connection.charged = held;
  return true;
}

}  // namespace

void EventLoop::advance(Connection& connection) {
  // Each returns false when the connection waits for something, or is no more.
  for (bool goes_on = true; goes_on;) {
    switch (connection.phase) {
      case Phase::kHead:
        goes_on = advance_head(connection);
        break;
      case Phase::kBody:
        goes_on = advance_body(connection);
        break;
      case Phase::kSending:
        goes_on = advance_sending(connection);
        break;
      case Phase::kLingering:
        advance_lingering(connection);
        return;
      case Phase::kAtWork:
        return;
    }
  }
}

void EventLoop::await_head(Connection& connection) {
  connection.phase = Phase::kHead;
  connection.scan = {};
  // What a refusal reads; parse_request_head makes all of it new.
  connection.head.method.clear();
  connection.head.request_id.clear();
  connection.head.key_name.clear();
  connection.head.origin.clear();
  connection.begun = connection.skip > 0;
  connection.idle_turn = ++turns_;
  connection.due = now_ + (connection.begun ? limits_.head_time.get() : limits_.idle.get());
}

bool EventLoop::advance_head(Connection& connection) {
  for (;;) {
    const auto skipped = static_cast<std::size_t>(
        std::min<std::uint64_t>(connection.skip, connection.pending_input().size()));
    if (skipped > 0) connection.take(skipped);
    connection.skip -= skipped;
    if (skipped > 0 && connection.skip == 0) {
      // All that has begun is over: from here on it is a silence between two requests.
      connection.begun = false;
      connection.due = now_ + limits_.idle.get();
    }
    if (!connection.pending_input().empty()) {
      switch (connection.scan.look(connection.pending_input(), limits_.head)) {
        case HeadScan::State::kWhole:
          admit(connection);
          return true;
        case HeadScan::State::kFault:
          refuse(connection, connection.scan.fault());
          return true;
        case HeadScan::State::kMore:
          break;
      }
      if (!connection.begun) connection.due = now_ + limits_.head_time.get();
      connection.begun = true;
    }
    const auto received =
        connection.readable ? receive_some(connection, kReceived) : Received::kNothing;
    note(connection, received);
    if (received == Received::kSome || received == Received::kAll) continue;
    // What came before a stop is still answered; silence ends the connection.
    if (received == Received::kEnd || (stopping_ && !connection.begun)) {
      close(connection);
      return false;
    }
    if (charge_head(connection)) return false;
    refuse(connection,
           {503, "MEMORY_BUSY", "too many long headers are on their way: try again later"});
    return true;
  }
}

void EventLoop::admit(Connection& connection) {
  const HeadScan& scan = connection.scan;
  const std::string_view text =
      connection.pending_input().substr(scan.begin(), scan.size() - scan.begin());
  if (const auto fault = parse_request_head(text, limits_.head, connection.head)) {
    return refuse(connection, *fault);
  }
  // Long heads take as long to read as several requests take to answer.
  connection.answered_here += static_cast<int>(scan.size() >> 10);
  connection.take(scan.size());
  connection.give_back_budget();
  if (rules_.admit) {
    if (const auto fault = rules_.admit(connection.head)) return refuse(connection, *fault);
  }
  const RequestHead& head = connection.head;
  connection.asked_at = now_;
  if (!head.has_body()) {
    if (answer_here(connection, 0)) return;
    return hand_over(connection, workers_for(connection, 0));
  }
  const std::uint64_t length = head.length.value_or(0);
  connection.owes_continue = head.expects_continue;
  connection.is_gathered = !head.chunked && !head.expects_continue && length <= kGathered &&
                           (length <= kFreeBody || budget_.charge(length));
  // What is wrong with its head is said before its body comes.
  if (!connection.is_gathered) return hand_over(connection, *ready_workers_);
  if (length > kFreeBody) connection.charged += length;
  begin_body(connection);
}

void EventLoop::begin_body(Connection& connection) {
  connection.phase = Phase::kBody;
  connection.pace = Pace(limits_.pace, now_);
  connection.busy_pace = Pace({limits_.busy_rate, limits_.pace.window, limits_.pace.longest}, now_);
  connection.due = connection.pace.due();
}

void EventLoop::go_on(Connection& connection) {
  hear(connection, Heard::kBytes);
  connection.output.clear();
  connection.sent = 0;
  const auto put_off = std::exchange(connection.put_off, Connection::PutOff::kNo);
  if (put_off == Connection::PutOff::kToStream) {
    connection.streams = true;
    return hand_over(connection, *stream_workers_);
  }
  if (put_off == Connection::PutOff::kToLong) return hand_over(connection, *long_workers_);
  // It may wait for memory there, beside other large ones.
  if (put_off == Connection::PutOff::kToWorker) {
    return hand_over(connection, connection.is_long ? *long_workers_ : *bulk_workers_);
  }
  if (connection.body) {
    // It comes in parts, at one pace.
    connection.phase = Phase::kBody;
    connection.due = connection.pace.due();
  } else {
    connection.body =
        std::make_unique<ReceivedBody>(connection.head, connection.budget, connection.spool);
    begin_body(connection);
  }
  // Said to a client that sends already it would stand in the answer [RFC9110] 10.1.1.
  if (std::exchange(connection.owes_continue, false) && connection.pending_input().empty()) {
    connection.output = kContinue;
    if (!send_pending(connection)) connection.ended = true;
  }
}

bool EventLoop::advance_body(Connection& connection) {
  return connection.body ? advance_stored(connection) : advance_gathered(connection);
}

bool EventLoop::advance_stored(Connection& connection) {
  ReceivedBody& body = *connection.body;
  const std::uint64_t wanted = connection.body_wanted, begin = body.size();
  bool waits = false;
  while (!waits && !body.is_whole() && !body.is_broken() && body.size() < wanted) {
    const auto left = static_cast<std::size_t>(
        std::min<std::uint64_t>(wanted - body.size(), std::numeric_limits<std::size_t>::max()));
    if (!connection.pending_input().empty()) {
      const std::uint64_t before = body.size();
      if (!take_body(connection, left)) {
        free_spool(connection);
        refuse(connection, spool_busy());
        return true;
      }
      connection.pace.moved(body.size() - before, now_);
      connection.busy_pace.moved(body.size() - before, now_);
      connection.due = connection.pace.due();
      continue;
    }
    if (body.size() - begin >= kInOneTurn) {
      go_on_later(connection);
      return false;
    }
    const auto received = connection.readable ? receive_some(connection, left) : Received::kNothing;
    note(connection, received);
    if (received == Received::kEnd) body.end();
    waits = received == Received::kNothing;
  }
  // A handler that takes its body in parts is told of what has come also when that is less.
  const bool is_due = connection.kept && body.unread() > 0 && now_ >= connection.part_due;
  if (waits && !is_due) return false;
  connection.asked_at = now_;
  connection.part_due = now_ + kPart;
  const bool is_long = !connection.kept && body.size() > kLongBody;
  if (is_long) {
    // What a few bytes cost little of costs by its size; of other requests the cost is not known yet.
    const bool costs_by_size = weight_of(connection, 0) == Weight::kInline;
    connection.expected = Connection::kUnknown;
    if (costs_by_size) connection.expect(body.size() / kBytesOfCost);
  }
  hand_over(connection, connection.kept ? *ready_workers_
                        : is_long       ? *long_workers_
                                        : *bulk_workers_);
  return true;
}

void EventLoop::free_spool(const Connection& spared) {
  for (const auto& slot : connections_) {
    if (!slot || slot.get() == &spared || spool_.is_small(slot->spooled())) continue;
    Connection& connection = *slot;
    if (connection.phase == Phase::kSending) note_taken(connection);
    const bool waits = connection.phase == Phase::kBody || connection.phase == Phase::kSending;
    if (!waits || now_ < connection.busy_pace.due()) continue;
    if (connection.phase == Phase::kSending) {
      reset(connection);
    } else {
      refuse(connection, spool_busy());
      go_on_later(connection);
    }
  }
}

bool EventLoop::advance_gathered(Connection& connection) {
  const auto length = static_cast<std::size_t>(connection.head.length.value_or(0));
  while (connection.pending_input().size() < length) {
    const std::size_t before = connection.pending_input().size();
    const auto received =
        connection.readable ? receive_some(connection, length - before) : Received::kNothing;
    note(connection, received);
    if (received == Received::kNothing) return false;
    // Whose body ends early is told so by the worker.
    if (received == Received::kEnd) break;
    connection.pace.moved(connection.pending_input().size() - before, now_);
    connection.due = connection.pace.due();
  }
  connection.asked_at = now_;
  const bool is_whole = connection.pending_input().size() >= length;
  if (!is_whole || !answer_here(connection, length)) {
    hand_over(connection, workers_for(connection, length));
  }
  return true;
}

bool EventLoop::has_time_for(Connection& connection) const {
  if (connection.not_tried > 0) {
    --connection.not_tried;
    return false;
  }
  // It is one thread: where there are processors enough, idle workers answer beside it.
  if (answered_here_ >= kAnsweredHere && processors_ > 2 && ready_workers_->has_idle())
    return false;
  return answered_here_ < kAnsweredInTurn && slow_here_ < kSlowInTurn;
}

bool EventLoop::answer_here(Connection& connection, std::size_t length) {
  if (connection.answered_here >= kAnsweredHere) return false;
  // What needs no body takes no time worth speaking of.
  if (length > 0 && !has_time_for(connection)) return false;
  if (weight_of(connection, length) != Weight::kInline) return false;
  const std::size_t taken = connection.taken;
  const Clock::time_point begin = Clock::now();
  connection.on_event_loop = true;
  answer(connection);
  connection.on_event_loop = false;
  if (Clock::now() - begin > kSlow) ++slow_here_;
  if (std::exchange(connection.put_off, Connection::PutOff::kNo) != Connection::PutOff::kNo) {
    connection.taken = taken;
    connection.output.clear();
    connection.broken = false;
    connection.not_tried = kNotTried;
    return false;
  }
  connection.take(0);
  connection.forget_body();
  ++connection.answered_here;
  ++answered_here_;
  ++counts_.answered;
  if (connection.broken) {
    connection.output.clear();
    connection.sent = 0;
    connection.keep = false;
  }
  begin_sending(connection);
  return true;
}

Weight EventLoop::weight_of(const Connection& connection, std::size_t length) const {
  const std::string_view body = connection.pending_input().substr(0, length);
  if (rules_.weigh) return rules_.weigh(connection.head, body);
  return body.size() <= kLittleBody ? Weight::kShort : Weight::kBulk;
}

WorkerPool& EventLoop::workers_for(Connection& connection, std::size_t length) {
  return weight_of(connection, length) == Weight::kBulk ? *bulk_workers_ : *ready_workers_;
}

void EventLoop::hand_over(Connection& connection, WorkerPool& workers) {
  connection.phase = Phase::kAtWork;
  connection.goes_first = &workers == ready_workers_.get();
  connection.is_long = &workers == long_workers_.get();
  connection.stirred = connection.readable || connection.ended;
  connection.due = now_ + kHalfClosed;
  const bool streams = &workers == stream_workers_.get();
  if (streams) hear(connection, Heard::kEnd);
  if (workers.submit(connection)) return;
  hear(connection, Heard::kBytes);
  ++counts_.overload;
  refuse(connection, streams
                         ? RequestFault{503, "STREAMS_BUSY",
                                        "as many streams are open as may be: try again later"}
                         : RequestFault{503, "QUEUE_FULL",
                                        "as many requests are waiting as may: try again later"});
}

void EventLoop::refuse(Connection& connection, const RequestFault& fault) {
  if (fault.status == 408) ++counts_.timed_out;
  if (fault.status == 401 || fault.status == 403) {
    ++counts_.locked_out;
  } else if (fault.status < 500 && fault.status != 408) {
    ++counts_.refused;
  }
  connection.take(connection.pending_input().size());
  connection.forget_body();
  connection.output_file.reset();
  connection.file_sent = 0;
  const std::string request_id = checked_request_id(connection.head.request_id, rules_.is_secret);
  if (rules_.refused) rules_.refused(connection.head, fault, request_id);
  const HttpResponse response = refusal(fault, request_id);
  connection.output.clear();
  append_head(connection.output, connection.head, response, request_id, true, rules_.headers);
  if (connection.head.method != "HEAD") connection.output += response.body;
  connection.sent = 0;
  connection.keep = false;
  begin_sending(connection);
}

void EventLoop::begin_sending(Connection& connection) {
  connection.phase = Phase::kSending;
  connection.pace = Pace(limits_.pace, now_);
  connection.busy_pace = Pace({limits_.busy_rate, limits_.pace.window, limits_.pace.longest}, now_);
  connection.due = connection.pace.due();
  connection.taken_before = connection.given;
}

void EventLoop::note_taken(Connection& connection) {
  const std::uint64_t taken = taken_by_client(connection);
  // The first count is less: all that was given is only an upper bound, which spares each answer a
  // system call at its beginning.
  if (taken > connection.taken_before) {
    connection.pace.moved(taken - connection.taken_before, now_);
    connection.busy_pace.moved(taken - connection.taken_before, now_);
  }
  connection.taken_before = taken;
  connection.due = connection.pace.due();
}

bool EventLoop::advance_sending(Connection& connection) {
  bool full = false;
  if (!send_pending(connection, kInOneTurn, full)) {
    close(connection);
    return false;
  }
  if (connection.has_output()) {
    note_taken(connection);
    hear(connection, Heard::kRoom);
    if (!full) go_on_later(connection);
    return false;
  }
  connection.give_back_budget();
  if (connection.keep) {
    await_head(connection);
  } else {
    linger(connection);
  }
  return true;
}

void EventLoop::linger(Connection& connection) {
  ::shutdown(connection.socket, SHUT_WR);
  connection.take(connection.pending_input().size());
  connection.phase = Phase::kLingering;
  connection.due = now_ + kLinger;
  connection.lingered = 0;
  connection.readable = true;
}

void EventLoop::advance_lingering(Connection& connection) {
  while (connection.lingered < kLingerBytes) {
    // Nobody reads them: they need not be copied.
    const ssize_t count =
        ::recv(connection.socket, nullptr, kLingerBytes, MSG_TRUNC | MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return;
    if (count <= 0) break;
    connection.lingered += static_cast<std::size_t>(count);
  }
  close(connection);
}

void EventLoop::on_late(Connection& connection) {
  switch (connection.phase) {
    case Phase::kHead:
      if (!connection.begun) return close(connection);
      refuse(connection, {408, "REQUEST_TIMEOUT", "the header of the request took too long"});
      break;
    case Phase::kBody:
      refuse(connection, {408, "REQUEST_TIMEOUT", "the body of the request came too slowly"});
      break;
    case Phase::kSending:
      note_taken(connection);
      if (now_ < connection.due) return;
      return reset(connection);
    case Phase::kLingering:
      return close(connection);
    case Phase::kAtWork:
      return;
  }
  advance(connection);
}

}  // namespace sightline
