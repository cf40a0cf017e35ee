#pragma once
/// Admission: the memory that connections and requests may hold in total (--memory).
///
/// A request reserves memory before it takes it. Where others have it, a request waits only while it
/// holds nothing, so no two wait for each other. A request that needs more than it has gives all
/// back and begins again, since its body is still there. It then waits until all that it needs is
/// free at once. Requests that wait get their memory in the order in which they came, except those
/// that fit beside the waiting ones.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/base/watch.h"

namespace sightline {

/// Bytes that are counted, not allocated. The last eighth is reserved for requests that hold at most
/// a sixteenth, which do not wait for larger ones. One request at a time may exceed the budget,
/// while all others hold at most half of it, and they get no more than that half until it ends.
/// Outlives its holders; may be used from many threads.
class MemoryBudget {
 public:
  /// all  bytes of connections and requests
  /// one  bytes of one request
  MemoryBudget(std::uint64_t all, std::uint64_t one) : all_(all), one_(one) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  /// For headers, bodies and answers in transfer: half of the budget. False, and nothing is taken,
  /// where there is not so much now.
  bool charge(std::uint64_t bytes);
  void release(std::uint64_t bytes);

  /// What one request has of it.
  struct Holder {
    std::uint64_t bytes = 0;
  };
  /// Takes so many bytes more; false, and nothing is taken, where there are not so many now.
  bool take(Holder& holder, std::uint64_t bytes);
  /// Waits for its turn until the deadline. Precondition: the holder has nothing, or may wait for
  /// others although it holds memory.
  bool wait(Holder& holder, std::uint64_t bytes, const Deadline& deadline);
  /// Gives back all but `bytes`.
  void keep(Holder& holder, std::uint64_t bytes);

  /// Bytes, by all.
  std::uint64_t taken() const;
  std::uint64_t one() const { return one_; }
  /// Whether somebody waits, and a holder of so many bytes matters.
  bool is_wanted(std::uint64_t bytes) const;

 private:
  // Precondition of all: mutex_ is held.
  bool is_small(std::uint64_t bytes) const { return bytes <= all_ / 16; }
  bool has_room(const Holder& holder, std::uint64_t bytes) const;
  /// Whether it need not queue behind those that wait.
  bool may_overtake(const Holder& holder, std::uint64_t bytes) const;
  bool try_take(Holder& holder, std::uint64_t bytes);

  const std::uint64_t all_, one_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< something was given back
  std::uint64_t taken_ = 0;
  std::uint64_t charged_ = 0;        ///< of that, what belongs to no request
  const Holder* large_ = nullptr;    ///< the holder beyond the budget; null while taken_ <= all_
  std::deque<const Holder*> queue_;  ///< those that wait, in their order
};

/// The memory of one request. One thread at a time.
class RequestMemory {
 public:
  /// State that a request that begins again takes over. `reserve` writes it on MEMORY_BUSY.
  struct Plan {
    std::uint64_t bytes = 0;
    Deadline::Clock::time_point until = Deadline::Clock::time_point::max();
  };
  enum class Wait {
    kNever,       ///< on the event loop: free bytes alone
    kBegunAgain,  ///< on a worker for small requests: a refused one begins again elsewhere
    kWhileEmpty,  ///< on other workers
    kStream       ///< also while it holds memory, for a few seconds: a stream cannot begin again
  };
  /// `plan` outlives this.
  RequestMemory(MemoryBudget& budget, Plan& plan, Wait wait, const CancelFlag* caller)
      : budget_(budget), plan_(plan), wait_(wait), caller_(caller) {}
  /// After a large request what was freed goes back to the system, before others get their turn.
  ~RequestMemory();
  RequestMemory(const RequestMemory&) = delete;
  RequestMemory& operator=(const RequestMemory&) = delete;

  /// To be called before the memory is taken. The first 256 KiB of a request are free: for all
  /// workers this is little. Errors, and nothing is reserved: MEMORY_BUSY (others have it),
  /// REQUEST_TOO_LARGE (it never fits), DEADLINE.
  Status reserve(std::uint64_t bytes);
  /// Of what was reserved so far no more than that is still in use, beside pinned bytes.
  void keep(std::uint64_t bytes);
  /// Reserves bytes that stay until unpin.
  Status pin(std::uint64_t bytes);
  void unpin() { pinned_ = 0; }
  /// Nothing more is reserved: the answer of so many bytes is ready.
  void finish(std::uint64_t bytes);
  /// Whether others wait for memory, and this has enough of it to matter.
  bool keeps_others_waiting() const { return budget_.is_wanted(holder_.bytes); }
  /// Whether the last reservation failed because others had the memory.
  bool was_refused() const { return was_refused_; }
  /// From now on nothing is waited for longer than that: reserve fails with DEADLINE then.
  void wait_until(Deadline::Clock::time_point at) { until_ = at; }

 private:
  Status grow(std::uint64_t held);

  MemoryBudget& budget_;
  Plan& plan_;
  const Wait wait_;
  const CancelFlag* const caller_;
  MemoryBudget::Holder holder_;
  std::uint64_t used_ = 0, pinned_ = 0, most_ = 0;
  std::uint64_t planned_ = 0;  ///< bytes that stay until finish
  bool was_refused_ = false;
  Deadline::Clock::time_point until_ = Deadline::Clock::time_point::max();
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
