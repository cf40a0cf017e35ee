#pragma once
/// Connection: the connection of a client, with the state of its present request.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/deadline.h"
#include "server/http/pace.h"
#include "server/http/received_body.h"
#include "server/http/request_head.h"
#include "server/http/request_memory.h"
#include "server/http/spool.h"

namespace sightline {

/// The socket of a client, its buffers, and the state of its present request. Owned in turn by the
/// event loop and by a worker; queues pass it on. Only `gone` and `stirred` may be accessed by both
/// at any time. The event loop closes the socket; the destructor only releases memory of `budget`.
struct Connection {
  /// `budget_given` and `spool_given` must outlive the connection.
  Connection(int socket_given, MemoryBudget& budget_given, Spool& spool_given)
      : socket(socket_given), budget(budget_given), spool(spool_given) {}
  ~Connection() { budget.release(charged); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Phases in the event loop: see event_loop.h.
  enum class Phase { kHead, kBody, kAtWork, kSending, kLingering };
  /// Events of the socket that wake the event loop. kEnd: only the end of the connection, while a
  /// stream reads its body. kBytes: also received bytes. kRoom: also room for bytes to send.
  enum class Heard { kEnd, kBytes, kRoom };
  /// Why a handler has returned without an answer. It is called again from the beginning when
  /// - kToWorker: a worker takes the request, which the event loop has tried to answer, or for
  ///   which another worker found no memory;
  /// - kForBody: `body_wanted` bytes of the body have arrived, or all of it;
  /// - kToLong: a worker for long requests takes it;
  /// - kToStream: a thread for streams takes it, which may wait for the client.
  enum class PutOff { kNo, kToWorker, kForBody, kToLong, kToStream };

  const int socket;  ///< non-blocking
  CancelFlag gone;   ///< set when the client no longer waits for an answer
  /// set if something arrived while a worker owned the connection
  std::atomic<bool> stirred{false};

  std::string input;  ///< received bytes; those before `taken` are processed
  std::size_t taken = 0;
  std::string output;  ///< bytes of the answer; those before `sent` are sent
  std::size_t sent = 0;
  std::unique_ptr<SpoolFile> output_file;  ///< sent after `output`; null: none
  std::uint64_t file_sent = 0;             ///< bytes of output_file that are sent
  /// bytes passed to the system for sending since the connection was accepted
  std::uint64_t given = 0;
  MemoryBudget& budget;
  Spool& spool;
  std::uint64_t charged = 0;  ///< bytes of the budget that this connection has taken

  RequestHead head;                                ///< head of the present request
  std::chrono::steady_clock::time_point asked_at;  ///< when the request was complete, with its body
  /// The body, if it is longer than what the event loop collects in `input`, or chunked, or sent
  /// only after a 100; null until a handler asks for it.
  std::unique_ptr<ReceivedBody> body;
  RequestMemory::Plan plan;       ///< of a request that begins again
  bool is_gathered = false;       ///< all of the body is in `input`
  std::uint64_t body_wanted = 0;  ///< for PutOff::kForBody
  bool owes_continue = false;     ///< the client waits for "100 Continue"
  bool streams = false;           ///< a thread for streams owns it
  bool is_long = false;           ///< a worker for long requests owns it
  std::shared_ptr<void> kept;     ///< state of a handler until it is called again
  std::uint64_t skip = 0;         ///< bytes of an unread body, before the next head
  bool keep = false;              ///< the connection stays open for a next request
  bool broken = false;            ///< sending the answer failed

  Heard heard = Heard::kBytes;  ///< what wakes the event loop now
  bool goes_first = false;      ///< a worker for small requests owns it
  // True while the event loop tries to answer: input and output may be rolled back.
  bool on_event_loop = false;
  PutOff put_off = PutOff::kNo;

  /// next connection in the list that holds this one; a link needs no memory
  Connection* next = nullptr;
  double expected = 0;  ///< seconds of a worker that the request is expected to take, if it is long
  std::array<double, 4> flows{};  ///< finish time of its flow in each WorkerPool, in virtual time

  // Members that only the event loop uses.
  Phase phase = Phase::kHead;
  HeadScan scan;
  bool begun = false;                         ///< bytes of the present head have arrived
  std::uint64_t idle_turn = 0;                ///< smaller: has waited longer for a head
  std::chrono::steady_clock::time_point due;  ///< when the present phase times out
  /// when the present part of a body in parts times out
  std::chrono::steady_clock::time_point part_due;
  Pace pace{{}, {}};
  Pace busy_pace{{}, {}};
  /// bytes that the client had acknowledged when `pace` was last updated
  std::uint64_t taken_before = 0;
  bool readable = true;  ///< the last receive did not report that there was nothing
  bool ended = false;    ///< the client has closed its side, or the connection
  std::chrono::steady_clock::time_point ended_at;
  std::uint64_t acknowledged = 0;  ///< bytes of `given`, when the send buffers were last counted
  std::size_t lingered = 0;        ///< bytes received while lingering
  /// requests, and KiB of heads, that the event loop answered itself since the last event
  int answered_here = 0;
  int not_tried = 0;  ///< so many of the next requests go to workers at once

  std::string_view pending_input() const { return std::string_view(input).substr(taken); }
  std::size_t pending_output() const { return output.size() - sent; }
  std::uint64_t pending_file() const { return output_file ? output_file->size() - file_sent : 0; }
  bool has_output() const { return pending_output() > 0 || pending_file() > 0; }
  /// Bytes of the spool that this connection uses.
  std::uint64_t spooled() const {
    return (body ? body->spooled() : 0) + (output_file ? output_file->size() : 0);
  }
  /// A cost (BodyReader::may_cost) is a rough estimate: more than that is not expected of any
  /// request.
  static constexpr double kMostExpected = 10;
  /// Expected of a request whose cost is not known. More than that is slow (WorkerPool).
  static constexpr double kUnknown = 5;
  /// Sets `expected` by the cost of the request.
  void expect(std::uint64_t cost) {
    constexpr double kSecondsOfCost = 0.05 / (64 << 10);
    expected = std::min(static_cast<double>(cost) * kSecondsOfCost, kMostExpected);
  }

  /// Frees all that belongs to the body of the present request.
  void forget_body() {
    body.reset();
    kept.reset();
    plan = {};
    is_gathered = streams = is_long = false;
    expected = 0;
  }

  /// Removes bytes from the front of the input.
  void take(std::size_t bytes) {
    taken += bytes;
    if (taken == input.size() && !on_event_loop) {
      // An idle connection uses almost no memory.
      if (input.capacity() > 4096) std::string().swap(input);
      input.clear();
      taken = 0;
      // Its bytes are counted elsewhere now.
      if (output.empty()) give_back_budget();
    }
  }
  /// Releases all that this connection has taken of the budget.
  void give_back_budget() {
    budget.release(charged);
    charged = 0;
  }
};

/// Sends `output`, then `output_file`, at most about `most` bytes, without waiting. Returns false
/// if the connection is broken. Sets `full` to whether the socket took no more.
bool send_pending(Connection& connection, std::uint64_t most, bool& full);
/// Sends all that the socket takes without waiting. Returns false if the connection is broken.
bool send_pending(Connection& connection);

/// The number of bytes that the client's system has acknowledged. A send buffer has megabytes, and
/// reports room only when a third of it is free; by that report a slow client that reads all the
/// time would seem idle.
std::uint64_t taken_by_client(const Connection& connection);
/// The number of bytes in the socket's send buffer: not sent, or not acknowledged by the client.
std::uint64_t send_buffer_bytes(const Connection& connection);

/// The result of receiving: some bytes; all that were there; nothing now; the connection has ended.
enum class Received { kSome, kAll, kNothing, kEnd };
/// Receives at most `size` bytes to `data` without waiting, and sets `count` to their number. kAll:
/// there are no more now; kEnd: also for a broken connection. Precondition: size is not 0.
Received receive_at(Connection& connection, char* data, std::size_t size, std::size_t& count);
/// Receives at most `most` bytes, and at most 32 KiB, and appends them to `input`. Otherwise like
/// receive_at.
Received receive_some(Connection& connection, std::size_t most);
/// Moves at most `most` bytes of the body from `input` to `body`. Returns false if the spool is
/// full; the bytes are then lost. Precondition: `body` is not null.
bool take_body(Connection& connection, std::size_t most);

}  // namespace sightline
