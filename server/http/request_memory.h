#pragma once
/// Admission of requests by memory: the memory that connections and requests may use in total
/// (--memory).
///
/// A request reserves memory before it allocates it. If there is not enough, a request waits only
/// while it holds no memory, so two requests never wait for each other. A request that needs more
/// than it holds releases all and begins again, because its body is still stored; it then waits
/// until all that it needs is free at once. Waiting requests get memory in the order of arrival,
/// except for requests that fit beside them.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/base/watch.h"

namespace sightline {

/// Counts bytes, without allocating. The last eighth is reserved for requests that hold at most a
/// sixteenth; these do not wait for larger ones. One request at a time may exceed the budget. It
/// may do so while all others hold at most half of the budget, and until it ends they get no more
/// than that half. Must outlive its holders. Thread-safe.
class MemoryBudget {
 public:
  /// all  bytes for connections and requests
  /// one  the most bytes of one request
  MemoryBudget(std::uint64_t all, std::uint64_t one) : all_(all), one_(one) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  /// Takes bytes for headers, bodies and answers in transfer, which may use half of the budget.
  /// Returns false, and takes nothing, if they are not free now.
  bool charge(std::uint64_t bytes);
  void release(std::uint64_t bytes);

  /// The bytes that a request holds.
  struct Holder {
    std::uint64_t bytes = 0;
  };
  /// Takes `bytes` more. Returns false, and takes nothing, if they are not free now.
  bool take(Holder& holder, std::uint64_t bytes);
  /// Takes `bytes` more, waiting in the queue until the deadline; returns false at the deadline.
  /// Precondition: the holder holds nothing, or is a stream, which may wait while it holds memory.
  bool wait(Holder& holder, std::uint64_t bytes, const Deadline& deadline);
  /// Releases all but `bytes`.
  void keep(Holder& holder, std::uint64_t bytes);

  /// Bytes that are taken in total.
  std::uint64_t taken() const;
  std::uint64_t all() const { return all_; }
  std::uint64_t one() const { return one_; }
  /// True if a request waits, and a holder of `bytes` delays it noticeably.
  bool is_wanted(std::uint64_t bytes) const;

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
  /// the request that exceeds the budget; null while taken_ <= all_
  const Holder* large_ = nullptr;
  std::deque<const Holder*> queue_;  ///< requests that wait, in their order
};

/// The memory of one request. Not thread-safe.
class RequestMemory {
 public:
  /// What a request that begins again must wait for. `reserve` sets it on MEMORY_BUSY.
  struct Plan {
    std::uint64_t bytes = 0;
    Deadline::Clock::time_point until = Deadline::Clock::time_point::max();
  };
  /// When a request waits for memory.
  enum class Wait {
    kNever,  ///< on the event loop: never
    /// on a worker for small requests: never; a refused request begins again on another worker
    kBegunAgain,
    kWhileEmpty,  ///< on other workers: while it holds nothing
    /// on the thread of a stream: also while it holds memory, for a few seconds, because it cannot
    /// begin again
    kStream
  };
  /// `plan` must outlive the object.
  RequestMemory(MemoryBudget& budget, Plan& plan, Wait wait, const CancelFlag* caller)
      : budget_(budget), plan_(plan), wait_(wait), caller_(caller) {}
  /// After a large request, returns freed memory to the system before other requests continue.
  ~RequestMemory();
  RequestMemory(const RequestMemory&) = delete;
  RequestMemory& operator=(const RequestMemory&) = delete;

  /// Reserves memory; to be called before it is allocated. The first 256 KiB of a request are free.
  /// Errors, after which nothing is reserved: MEMORY_BUSY (other requests hold it),
  /// REQUEST_TOO_LARGE (it never fits), DEADLINE.
  Status reserve(std::uint64_t bytes);
  /// Releases what was reserved so far, except for `bytes` and pinned bytes.
  void keep(std::uint64_t bytes);
  /// Reserves bytes that stay reserved until unpin.
  Status pin(std::uint64_t bytes);
  void unpin() { pinned_ = 0; }
  /// To be called when the answer of `bytes` bytes is ready; nothing more is reserved.
  void finish(std::uint64_t bytes);
  /// True if other requests wait for memory, and this one holds enough to matter.
  bool keeps_others_waiting() const { return budget_.is_wanted(holder_.bytes); }
  /// True if the last reservation failed because other requests held the memory.
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
/// A function that calls RequestMemory::reserve; `memory` must outlive it.
inline ReserveBytes reserve_from(RequestMemory* memory) {
  return [memory](std::uint64_t bytes) { return reserve(memory, bytes); };
}

}  // namespace sightline
