#pragma once
/// The connection of one client, between the event loop and a worker.

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

/// The event loop and a worker own it in turn; a queue hands it over. Only `gone` and `stirred` may
/// be used by both at any time.
struct Connection {
  Connection(int socket_given, MemoryBudget& budget_given, Spool& spool_given)
      : socket(socket_given), budget(budget_given), spool(spool_given) {}
  ~Connection() { budget.release(charged); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Phases in the event loop, see EventLoop.
  enum class Phase { kHead, kBody, kAtWork, kSending, kLingering };
  /// Events of the socket that wake the event loop. kEnd: only the end, while a stream reads its
  /// body. kBytes: also bytes to receive. kRoom: also room for bytes to send.
  enum class Heard { kEnd, kBytes, kRoom };
  /// Why a handler returns without an answer. It is called again, as if for the first time, when
  /// - kToWorker: a worker takes the request, which the event loop has tried to answer, or for
  ///   which another worker found no memory;
  /// - kForBody: `body_wanted` bytes of the body have come, or all of it;
  /// - kToLong: a worker for long requests takes it;
  /// - kToStream: a thread for streams takes it, which may wait for the client.
  enum class PutOff { kNo, kToWorker, kForBody, kToLong, kToStream };

  const int socket;                  ///< does not block
  CancelFlag gone;                   ///< set when nobody waits for an answer any more
  std::atomic<bool> stirred{false};  ///< whether something came while a worker had it

  std::string input;  ///< what was received and not yet taken, from `taken` on
  std::size_t taken = 0;
  std::string output;  ///< what was said and not yet sent, from `sent` on
  std::size_t sent = 0;
  std::unique_ptr<SpoolFile> output_file;  ///< what is sent after `output`; null: nothing
  std::uint64_t file_sent = 0;             ///< bytes of it
  std::uint64_t given = 0;  ///< bytes to the system, to be sent, since the connection began
  MemoryBudget& budget;
  Spool& spool;
  std::uint64_t charged = 0;  ///< bytes of the budget that this connection holds

  RequestHead head;                                ///< of the request that is being answered
  std::chrono::steady_clock::time_point asked_at;  ///< when it was whole, its body too
  /// A body that is longer than what the event loop gathers in `input`, chunked, or sent only after
  /// a 100; null until a handler asks for it.
  std::unique_ptr<ReceivedBody> body;
  RequestMemory::Plan plan;       ///< of a request that begins again
  bool is_gathered = false;       ///< all of the body that will come is in `input`
  std::uint64_t body_wanted = 0;  ///< see PutOff::kForBody
  bool owes_continue = false;     ///< the client waits for "100 Continue"
  bool streams = false;           ///< a thread for streams has it
  bool is_long = false;           ///< a worker for long requests has it
  std::shared_ptr<void> kept;     ///< state of a handler until it is called again
  std::uint64_t skip = 0;         ///< bytes of an unread body, before the next head
  bool keep = false;              ///< whether there may be a next request
  bool broken = false;            ///< whether the answer did not get through

  Heard heard = Heard::kBytes;
  bool goes_first = false;  ///< whether a worker for small requests has it
  // While the event loop tries to answer: neither input nor output is final.
  bool on_event_loop = false;
  PutOff put_off = PutOff::kNo;

  Connection* next = nullptr;     ///< in the list that has it: that takes no memory
  std::array<double, 4> flows{};  ///< what it has had of each WorkerPool

  // Only for the event loop.
  Phase phase = Phase::kHead;
  HeadScan scan;
  bool begun = false;                              ///< whether something of this head has come
  std::uint64_t idle_turn = 0;                     ///< the smaller, the longer it waits for a head
  std::chrono::steady_clock::time_point due;       ///< when this phase has lasted too long
  std::chrono::steady_clock::time_point part_due;  ///< of a body that is taken in parts
  Pace pace{{}, {}};
  Pace busy_pace{{},
                 {}};  ///< at the busy rate: a slower one that holds much of the spool may be ended
  std::uint64_t taken_before = 0;  ///< bytes that the client had taken when `pace` last heard of it
  bool readable = true;  ///< whether to try: no receive has said "not now" since the last event
  bool ended = false;    ///< the client has closed its side, or all
  std::chrono::steady_clock::time_point ended_at;
  std::size_t lingered = 0;  ///< bytes
  int answered_here = 0;     ///< since the last event, by no worker: requests, and KiB of heads
  int not_tried = 0;         ///< so many of the next go to workers at once

  std::string_view pending_input() const { return std::string_view(input).substr(taken); }
  std::size_t pending_output() const { return output.size() - sent; }
  std::uint64_t pending_file() const { return output_file ? output_file->size() - file_sent : 0; }
  bool has_output() const { return pending_output() > 0 || pending_file() > 0; }
  /// Bytes of the spool that this connection holds.
  std::uint64_t spooled() const {
    return (body ? body->spooled() : 0) + (output_file ? output_file->size() : 0);
  }
  void forget_body() {
    body.reset();
    kept.reset();
    plan = {};
    is_gathered = streams = is_long = false;
  }

  void take(std::size_t bytes) {
    taken += bytes;
    if (taken == input.size() && !on_event_loop) {
      // An idle connection holds next to nothing.
      if (input.capacity() > 4096) std::string().swap(input);
      input.clear();
      taken = 0;
      // Its bytes are counted elsewhere now.
      if (output.empty()) give_back_budget();
    }
  }
  void give_back_budget() {
    budget.release(charged);
    charged = 0;
  }
};

/// Sends what is to be sent, at most some `most` bytes, as far as it goes without waiting. False
/// when the connection is broken. `full` says whether the socket took no more.
bool send_pending(Connection& connection, std::uint64_t most, bool& full);
/// Sends everything that the socket takes without waiting. False when the connection is broken.
bool send_pending(Connection& connection);

/// Bytes that the system of the client has acknowledged. A send buffer holds megabytes and reports
/// room only when a third of it is free. By that report, a slow client that reads all the time
/// would seem to be silent.
std::uint64_t taken_by_client(const Connection& connection);

enum class Received { kSome, kAll, kNothing, kEnd };
/// Receives at most `size` bytes to `data` without waiting, and says in `count` how many: kAll when
/// there are no more now, kEnd also of a broken connection. Precondition: size is not 0.
Received receive_at(Connection& connection, char* data, std::size_t size, std::size_t& count);
/// Receives at most `most` bytes to the end of `input`, likewise.
Received receive_some(Connection& connection, std::size_t most);
/// Moves bytes of the body from `input` to `body`, at most `most`. False where the spool is full.
bool take_body(Connection& connection, std::size_t most);

}  // namespace sightline
