#pragma once
/// The bytes that all traffic holds together: what connections have waiting, the bodies and the
/// work of requests. Each kind has a limit of its own besides; this one bounds their sum.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

namespace sightline {

/// Counted and not allocated. Nobody gets more while the sum would pass `all`, but for one request
/// that is larger than that: it may have what it likes while all others together have no more than
/// half, and they get no more than that as long as it is there. The last eighth, of all or of that
/// half, is kept for requests that have little: they need not wait for those who have much, and who
/// may wait for their clients. Outlives who holds some; may be used from many threads.
class TrafficMemory {
 public:
  explicit TrafficMemory(std::uint64_t all) : all_(all) {}
  TrafficMemory(const TrafficMemory&) = delete;
  TrafficMemory& operator=(const TrafficMemory&) = delete;

  /// What one request has of it.
  class Holder {
    friend class TrafficMemory;
    std::uint64_t bytes_ = 0;
  };
  /// False, and nothing is taken, where there is not so much now. `holder`: null for what belongs
  /// to no request yet, or to none any more.
  bool take(Holder* holder, std::uint64_t bytes);
  /// Precondition: it was taken.
  void give(Holder* holder, std::uint64_t bytes);
  /// Bytes, by all.
  std::uint64_t taken() const;

 private:
  /// Keeps a part of it under the same lock.
  friend class WorkMemory;

  /// While it lives its holder, who has it alone, waits for more. All of it: mutex_ is held.
  class Waiter {
   public:
    /// could_go_on  whether it would get that more, beside `taken` of all bytes
    Waiter(TrafficMemory& memory, const Holder& holder,
           std::function<bool(std::uint64_t taken)> could_go_on);
    ~Waiter();
    Waiter(const Waiter&) = delete;
    Waiter& operator=(const Waiter&) = delete;
    /// Whether this one has to give up: all who have something wait for each other, and not for
    /// what belongs to no request, which goes by itself; or all have waited for that for long: its
    /// clients take their time. One at a time is told so, the next when that one has given back its
    /// own.
    bool gives_way();

   private:
    TrafficMemory& memory_;
    const std::function<bool(std::uint64_t)> could_go_on_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    bool counts_;  ///< it has something
  };

  // Of all these: mutex_ is held.
  /// Whether there is so much beside `taken`.
  bool has_room(const Holder* holder, std::uint64_t bytes, std::uint64_t taken) const;
  /// Whether who has nothing yet may begin with so much: while others who have something wait for
  /// more, only where no more than half is taken.
  bool lets_begin(const Holder& holder, std::uint64_t bytes) const;
  /// Precondition: has_room.
  void add(Holder* holder, std::uint64_t bytes);
  void subtract(Holder* holder, std::uint64_t bytes);

  const std::uint64_t all_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< something was given back
  std::uint64_t taken_ = 0;
  std::uint64_t nobodys_ = 0;       ///< of that, what belongs to no request
  const Holder* large_ = nullptr;   ///< who went beyond; null whenever the sum is within `all_`
  std::size_t holders_ = 0;         ///< that have something
  std::vector<Waiter*> waiters_{};  ///< of those, who wait for more
};

}  // namespace sightline
