#pragma once
/// The bytes that all traffic holds together: what connections have waiting, the bodies and the
/// work of requests. Each kind has a limit of its own besides; this one bounds their sum.

#include <cstdint>
#include <mutex>

namespace sightline {

/// Counted and not allocated. Nobody gets more while the sum would pass `all`, but for one request
/// that is larger than that: it may have what it likes while all others together have no more than
/// half, and they get no more than that as long as it is there. Outlives who holds some; may be
/// used from many threads.
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

  /// While it lives its holder, who has it alone, waits for more.
  class Waiter {
   public:
    Waiter(TrafficMemory& memory, const Holder& holder);
    ~Waiter();
    Waiter(const Waiter&) = delete;
    Waiter& operator=(const Waiter&) = delete;
    /// Whether this one, who waits for so many bytes, has to give up: all who have something wait
    /// for each other. One at a time is told so, the next when that one has given back its own.
    bool gives_way(std::uint64_t bytes);

   private:
    TrafficMemory& memory_;
    const Holder& holder_;
    bool counts_;
  };

 private:
  /// Precondition: mutex_ is held.
  bool has_room(const Holder* holder, std::uint64_t bytes) const;

  const std::uint64_t all_;
  std::mutex mutex_;
  std::uint64_t taken_ = 0;
  const Holder* large_ = nullptr;  ///< who went beyond; null whenever the sum is within `all_`
  int holders_ = 0, waiting_ = 0;  ///< of those that have something, and how many of them wait
};

}  // namespace sightline
