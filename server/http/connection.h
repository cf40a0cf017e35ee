#pragma once
/// One client's connection between the door and a worker.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/deadline.h"
#include "server/http/pace.h"
#include "server/http/request_head.h"
#include "server/http/traffic_memory.h"

namespace sightline {

/// Bytes that connections may hold together, of those of the traffic. May be used from many
/// threads.
class ByteBudget {
 public:
  ByteBudget(TrafficMemory& traffic, std::uint64_t bytes)
      : traffic_(traffic), left_(static_cast<std::int64_t>(bytes)) {}
  bool charge(std::uint64_t bytes) {
    const auto wanted = static_cast<std::int64_t>(bytes);
    if (left_.fetch_sub(wanted) >= wanted && traffic_.take(nullptr, bytes)) return true;
    left_ += wanted;
    return false;
  }
  void release(std::uint64_t bytes) {
    if (bytes == 0) return;
    traffic_.give(nullptr, bytes);
    left_ += static_cast<std::int64_t>(bytes);
  }

 private:
  TrafficMemory& traffic_;
  std::atomic<std::int64_t> left_;
};

/// The door and a worker have it in turn; a queue between them hands it over. Only `gone` and
/// `stirred` are for both at any time.
struct Connection {
  Connection(int socket_given, ByteBudget& budget_given)
      : socket(socket_given), budget(budget_given) {}
  ~Connection() { budget.release(charged); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// A door's phases, see ConnectionGate.
  enum class Phase { kHead, kBody, kAtWork, kSending, kLingering };
  /// What the door is told of: only the end, where a worker reads a long body and each piece would
  /// wake the door in vain; also bytes that come; also room for what is to be sent.
  enum class Heard { kEnd, kBytes, kRoom };

  const int socket;                  ///< does not block
  CancelFlag gone;                   ///< set when nobody waits for an answer any more
  std::atomic<bool> stirred{false};  ///< whether something came while a worker had it

  std::string input;  ///< what was received and not yet taken, from `taken` on
  std::size_t taken = 0;
  std::string output;  ///< what was said and not yet sent, from `sent` on
  std::size_t sent = 0;
  std::uint64_t given = 0;  ///< bytes to the system, to be sent, since the connection began
  ByteBudget& budget;
  std::uint64_t charged = 0;  ///< bytes of the budget that this connection holds

  RequestHead head;                                ///< of the request that is being answered
  std::chrono::steady_clock::time_point asked_at;  ///< when it was whole, a gathered body too
  std::uint64_t skip = 0;  ///< bytes of an unread body, before the next head
  bool keep = false;       ///< whether there may be a next request
  bool broken = false;     ///< whether the answer did not get through

  Heard heard = Heard::kBytes;
  bool goes_first = false;  ///< whether it is asked on a worker that is kept for little
  // While the door's thread tries to answer: nothing is taken or said for good.
  bool at_door = false;
  bool put_off = false;  ///< what came of it: a worker has to begin anew

  Connection* next = nullptr;  ///< in the queue or the list that has it: they take no memory

  // The door's own.
  Phase phase = Phase::kHead;
  HeadScan scan;
  bool begun = false;                         ///< whether something of this head has come
  std::uint64_t idle_turn = 0;                ///< the smaller, the longer it waits for a head
  std::chrono::steady_clock::time_point due;  ///< when this phase has lasted too long
  Pace pace{{}, {}};
  std::uint64_t taken_before = 0;  ///< bytes that the client had taken when `pace` last heard of it
  bool readable = true;  ///< whether to try: no receive has said "not now" since the last event
  bool ended = false;    ///< the client has closed its side, or all
  std::chrono::steady_clock::time_point ended_at;
  std::size_t lingered = 0;  ///< bytes
  int answered_here = 0;     ///< since the last event, by no worker: requests, and KiB of heads
  int not_tried = 0;         ///< so many of the next go to workers at once

  std::string_view pending_input() const { return std::string_view(input).substr(taken); }
  std::size_t pending_output() const { return output.size() - sent; }

  void take(std::size_t bytes) {
    taken += bytes;
    if (taken == input.size() && !at_door) {
      // An idle connection holds next to nothing.
      if (input.capacity() > 4096) std::string().swap(input);
      input.clear();
      taken = 0;
      // It is with who has taken it now.
      if (output.empty()) give_back_budget();
    }
  }
  void give_back_budget() {
    budget.release(charged);
    charged = 0;
  }
};

/// Sends what is to be sent, as far as it goes without waiting. False when the connection is
/// broken.
bool send_pending(Connection& connection);

/// Of all that was given to the system, how many bytes the client's system has taken. A send buffer
/// holds megabytes, and tells of room only when a third of it is free: a slow client that takes
/// all the time looks silent from there.
std::uint64_t taken_by_client(const Connection& connection);

enum class Received { kSome, kAll, kNothing, kEnd };
/// Receives at most `size` bytes to `data` without waiting, and says in `count` how many: kAll when
/// there are no more now, kEnd also of a broken connection. Precondition: size is not 0.
Received receive_at(Connection& connection, char* data, std::size_t size, std::size_t& count);
/// The same, at most `most` bytes, to the end of `input`.
Received receive_some(Connection& connection, std::size_t most);

}  // namespace sightline
