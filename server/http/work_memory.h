#pragma once
/// Memory that requests share: a request that does not fit waits for its turn, or is refused.

#include <atomic>
#include <cstdint>
#include <deque>

#include "core/base/deadline.h"
#include "core/base/places.h"
#include "core/base/result.h"
#include "core/base/watch.h"
#include "server/http/traffic_memory.h"

namespace sightline {

/// A number of bytes that are counted, not allocated. One share at a time may exceed it, up to a
/// limit of its own, and is then counted separately. So no smaller share waits for ever, no two
/// wait for each other, and small ones go on beside a large one. The last eighth is reserved for
/// small shares. All bytes count in the TrafficMemory too. Outlives its shares; may be used from
/// many threads.
class WorkMemory {
 public:
  /// all  bytes for all shares, except a share that exceeds it
  /// one  bytes for one share
  /// begins_late  for shares that grow slowly. While other shares wait for more, a new one begins
  /// only where at most half of the TrafficMemory is taken. Otherwise all would begin and none
  /// could end.
  WorkMemory(TrafficMemory& traffic, std::uint64_t all, std::uint64_t one, bool begins_late = false)
      : traffic_(traffic), all_(all), one_(one), begins_late_(begins_late) {}
  std::uint64_t all() const { return all_; }
  /// The largest of little shares.
  std::uint64_t little() const { return all_ / 16; }
  /// Whether somebody waits for a share.
  bool is_wanted() const { return waiting_ > 0; }

  class Share {
   public:
    Share(WorkMemory& memory, TrafficMemory::Holder& holder) : memory_(memory), holder_(holder) {}
    ~Share() { keep(0); }
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    /// Adds to the share. Errors, and nothing is added: MEMORY_BUSY (it does not fit now),
    /// REQUEST_TOO_LARGE (it never will).
    Status grow(std::uint64_t bytes) { return wait(bytes, {.at = Deadline::Clock::time_point()}); }
    /// Adds to the share, and waits for its turn until the deadline, or until no share could go on
    /// before another one shrinks. Errors: those of grow.
    /// stays_little  it will not become large: it need not begin late
    Status wait(std::uint64_t bytes, const Deadline& deadline, bool stays_little = false);
    /// Gives back all but so many, and so many more that stay counted with the traffic alone.
    void keep(std::uint64_t bytes, std::uint64_t beside = 0);
    std::uint64_t bytes() const { return bytes_; }

   private:
    // Precondition of both: the traffic's mutex_ is held.
    /// Whether there is room for it, were it so large, beside so many bytes of others.
    bool is_within(std::uint64_t size, std::uint64_t others) const;
    /// Whether it would grow if all traffic had taken so many bytes.
    bool fits(std::uint64_t bytes, std::uint64_t traffic_taken) const;
    bool try_grow(std::uint64_t bytes, bool stays_little);

    WorkMemory& memory_;
    TrafficMemory::Holder& holder_;
    std::uint64_t bytes_ = 0, beside_ = 0;
  };

 private:
  TrafficMemory& traffic_;
  const std::uint64_t all_, one_;
  const bool begins_late_;
  std::atomic<int> waiting_{0};
  // Under the traffic's mutex_.
  std::uint64_t taken_ = 0;           ///< by all shares but the next
  std::deque<const Share*> queue_{};  ///< shares that wait to begin, in their order
  const Share* beyond_ = nullptr;     ///< the share beyond the limit
};

/// What one request has of it.
class RequestMemory {
 public:
  /// waiters  places for requests that wait for memory; null: any number may wait
  /// at_door  on the thread of the event loop: no waiting, only free bytes
  RequestMemory(WorkMemory& bodies, WorkMemory& work, Places* waiters, const CancelFlag* caller,
                bool at_door = false)
      : bodies_(bodies),
        memory_(work),
        body_(bodies, holder_),
        work_(work, holder_),
        waiters_(waiters),
        caller_(caller),
        at_door_(at_door) {}
  /// After a large answer what was freed goes back to the system, before others get their turn.
  ~RequestMemory();
  RequestMemory(const RequestMemory&) = delete;
  RequestMemory& operator=(const RequestMemory&) = delete;

  /// Of the bytes of a long body, as they come, and of what decodes them. Waits for a turn: the
  /// client may be sending the rest, and would not see a refusal. Errors as below.
  /// stays_little  all that will come is little: it need not let those go first that have begun
  Status reserve_body(std::uint64_t bytes, bool stays_little = false);
  void forget_body() { body_.keep(0); }
  /// To be called before the memory is taken; waits for its turn. The first 256 KiB of a request
  /// are free: for all workers this is little. Errors: those of WorkMemory::Share. On the event
  /// loop MEMORY_BUSY for all that is not free.
  Status reserve(std::uint64_t bytes);
  /// Of what was reserved so far no more than that is still in use.
  void keep(std::uint64_t bytes);
  /// Of what was reserved, `bytes` stay in use for a part of a stream that is being sent. A slow
  /// client must not delay other requests: all of a large part counts in the TrafficMemory, but only
  /// the bytes of a small part count as work.
  void keep_while_streaming(std::uint64_t bytes);
  /// Whether so much of work would be little.
  bool is_little(std::uint64_t bytes) const;
  /// Whether others wait for memory, and this has enough of it to matter: of work, or of a body.
  bool keeps_others_waiting() const;
  bool body_keeps_others_waiting() const;
  /// Whether the last reservation failed because others had the memory.
  bool was_refused() const { return was_refused_; }
  /// From now on nothing is waited for longer than that: reserve fails with DEADLINE then.
  void wait_until(Deadline::Clock::time_point at) { until_ = at; }

 private:
  const WorkMemory &bodies_, &memory_;
  TrafficMemory::Holder holder_;
  WorkMemory::Share body_;
  WorkMemory::Share work_;  ///< what it takes to decode, answer and encode it
  std::uint64_t bytes_ = 0, most_ = 0;
  bool was_refused_ = false;
  Deadline::Clock::time_point until_ = Deadline::Clock::time_point::max();
  Places* const waiters_;
  const CancelFlag* const caller_;
  const bool at_door_;
};

/// RequestMemory::reserve; success where `memory` is null.
inline Status reserve(RequestMemory* memory, std::uint64_t bytes) {
  return memory == nullptr ? success() : memory->reserve(bytes);
}
/// RequestMemory::reserve as a callback; `memory` outlives it.
inline ReserveBytes reserve_from(RequestMemory* memory) {
  return [memory](std::uint64_t bytes) { return reserve(memory, bytes); };
}

}  // namespace sightline
