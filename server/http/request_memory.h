#pragma once
/// Admission of requests by memory, which limits the memory that connections and requests use in
/// total (--memory). One request at a time may exceed the limit: see MemoryBudget.
///
/// A request reserves memory before it allocates it. If there is not enough, a request that is no
/// stream waits only while it holds none, so two such requests never wait for each other. If it
/// holds some, its reservation fails with MEMORY_BUSY. The server then frees all that the request
/// holds and calls its handler again, because the body is still stored. Now it waits until all that
/// it needs is free at once, for ten minutes at most. A stream cannot begin again: it waits for at
/// most ten seconds, also while it holds memory. Waiting requests get memory in the order of
/// arrival, except for requests that fit beside them.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/base/watch.h"

namespace sightline {

/// The bytes that all connections and requests have reserved. It only counts: memory is allocated
/// elsewhere. Must outlive its holders. Thread-safe.
///
/// The last eighth is reserved for requests that hold at most a sixteenth; these do not wait for
/// larger ones. One request at a time may exceed the budget, up to the limit of one request. It may
/// do so if all others hold at most half of the budget. Until the sum fits again, the others get no
/// more than that half.
class MemoryBudget {
 public:
  /// all  bytes for connections and requests
  /// one  the most bytes of one request; may exceed `all`
  MemoryBudget(std::uint64_t all, std::uint64_t one) : all_(all), one_(one) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  /// Takes bytes for headers, bodies and answers in transfer. Returns false, and takes nothing, if
  /// they are not free now, or if all that was taken so would exceed 1 / `part` of the budget.
  bool charge(std::uint64_t bytes, std::uint64_t part = 2);
  /// Gives back bytes that charge() took.
  void release(std::uint64_t bytes);

  /// The bytes that a request holds. One thread at a time may use it; it must not move while it
  /// holds bytes.
  struct Holder {
    std::uint64_t bytes = 0;
  };
  /// Takes `bytes` more. Returns false, and takes nothing, if they are not free now, or if other
  /// requests wait for them.
  bool take(Holder& holder, std::uint64_t bytes);
  /// Takes `bytes` more, waiting in the queue until the deadline. Returns false, and takes nothing,
  /// at the deadline. Precondition: the holder holds nothing, or belongs to a stream.
  bool wait(Holder& holder, std::uint64_t bytes, const Deadline& deadline);
  /// Releases all but `bytes`; nothing if the holder has no more than that.
  void keep(Holder& holder, std::uint64_t bytes);

  /// Bytes that are taken in total.
  std::uint64_t taken() const;
  std::uint64_t all() const { return all_; }
  std::uint64_t one() const { return one_; }
  /// True if a request waits, and a holder of `bytes` delays it noticeably.
  bool is_wanted(std::uint64_t bytes) const;
  /// Counts `bytes` that a request has freed. Returns true, and counts from 0 again, if the freed
  /// memory of the process should be returned to the system. That is after every 32 MiB, and at once
  /// where it and the reservations exceed a quarter of the budget.
  bool count_freed(std::uint64_t bytes);

 private:
  // Preconditions: mutex_ is held.
  bool is_small(std::uint64_t bytes) const { return bytes <= all_ / 16; }
  bool has_room(const Holder& holder, std::uint64_t bytes) const;
  /// True if a request may take memory before those that wait.
  bool may_overtake(const Holder& holder, std::uint64_t bytes) const;
  bool try_take(Holder& holder, std::uint64_t bytes);

  const std::uint64_t all_, one_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< memory was released
  std::uint64_t taken_ = 0;
  std::uint64_t charged_ = 0;  ///< part of taken_ that belongs to no request
  std::uint64_t freed_ = 0;    ///< of count_freed
  /// the request that exceeds the budget; null while taken_ <= all_
  const Holder* large_ = nullptr;
  std::deque<const Holder*> queue_;  ///< requests that wait, in their order
};

/// The memory of one request, during one call of its handler: reserve() before each allocation;
/// finish() when the answer is ready. Not thread-safe.
class RequestMemory {
 public:
  /// What a request that begins again must wait for. A reservation that fails with MEMORY_BUSY sets
  /// it, except for Wait::kNever; the first reservation of the next call uses it.
  struct Plan {
    std::uint64_t bytes = 0;                                                 ///< to take at once
    Deadline::Clock::time_point until = Deadline::Clock::time_point::max();  ///< and no later
  };
  /// When a request waits for memory.
  enum class Wait {
    /// on the event loop: never, and only the bytes that are not counted are granted
    kNever,
    /// on a worker for small requests: never; a refused request begins again on another worker
    kBegunAgain,
    kWhileEmpty,  ///< on other workers: while it holds nothing
    /// on the thread of a stream: also while it holds memory, for ten seconds or until wait_until,
    /// because it cannot begin again
    kStream
  };
  /// `budget`, `plan` and `caller` must outlive the object.
  /// caller  set when the client no longer waits, which ends a wait; may be null
  RequestMemory(MemoryBudget& budget, Plan& plan, Wait wait, const CancelFlag* caller)
      : budget_(budget), plan_(plan), wait_(wait), caller_(caller) {}
  /// Releases the whole reservation. After requests of 1 MiB or more, also returns freed memory of
  /// the process to the system (MemoryBudget::count_freed).
  ~RequestMemory();
  RequestMemory(const RequestMemory&) = delete;
  RequestMemory& operator=(const RequestMemory&) = delete;

  /// Reserves `bytes` more; to be called before they are allocated. May wait: see Wait. The first
  /// 256 KiB of a request are not counted. Errors, after which the reservation is as before:
  /// MEMORY_BUSY (other requests hold the memory, or Wait::kNever), REQUEST_TOO_LARGE (more than
  /// one request may use), DEADLINE, CANCELLED.
  Status reserve(std::uint64_t bytes);
  /// Releases what was reserved so far, except for `bytes`, pinned bytes, and those of the plan.
  void keep(std::uint64_t bytes);
  /// Reserves bytes that keep() does not release until unpin(). Errors: those of reserve.
  Status pin(std::uint64_t bytes);
  /// Makes pinned bytes ordinary ones; the next keep() or finish() releases them.
  void unpin() { pinned_ = 0; }
  /// Releases all but `bytes` and pinned bytes. To be called when the answer, of `bytes` bytes, is
  /// ready.
  void finish(std::uint64_t bytes);
  /// True if other requests wait for memory, and this one holds more than a 64th of the budget.
  bool keeps_others_waiting() const { return budget_.is_wanted(holder_.bytes); }
  /// True if the last reservation failed because other requests held the memory. Always false for
  /// Wait::kNever.
  bool was_refused() const { return was_refused_; }
  /// Sets the time until which reserve() may wait; afterwards it fails with DEADLINE.
  void wait_until(Deadline::Clock::time_point at) { until_ = at; }

 private:
  Status grow(std::uint64_t held);

  MemoryBudget& budget_;
  Plan& plan_;
  const Wait wait_;
  const CancelFlag* const caller_;
  MemoryBudget::Holder holder_;
  std::uint64_t used_ = 0, pinned_ = 0, most_ = 0;
  std::uint64_t planned_ = 0;  ///< bytes that stay reserved until finish
  bool was_refused_ = false;
  Deadline::Clock::time_point until_ = Deadline::Clock::time_point::max();
};

/// RequestMemory::reserve; success if `memory` is null.
inline Status reserve(RequestMemory* memory, std::uint64_t bytes) {
  return memory == nullptr ? success() : memory->reserve(bytes);
}
/// A function that calls RequestMemory::reserve; `memory` may be null, else it must outlive the
/// function.
inline ReserveBytes reserve_from(RequestMemory* memory) {
  return [memory](std::uint64_t bytes) { return reserve(memory, bytes); };
}

}  // namespace sightline
