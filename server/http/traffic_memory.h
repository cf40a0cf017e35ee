#pragma once
/// The memory of all connections and requests: buffers, bodies and work. Each kind has a limit of
/// its own besides; this class limits the sum.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

namespace sightline {

/// Bytes that are counted, not allocated. A request gets no more while the sum would exceed `all`.
/// One request that is larger than that may exceed it while all others have at most half of `all`;
/// they get no more than that half until it ends. The last eighth, of all or of that half, is
/// reserved for small requests, so that they do not wait for large ones. Outlives its holders; may
/// be used from many threads.
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
  /// Counts a part of it under the same lock.
  friend class WorkMemory;

  /// While it lives, its holder waits for more; the holder has no other waiter. Precondition of all
  /// members: mutex_ is held.
  class Waiter {
   public:
    /// could_go_on  whether it would get that more, beside `taken` of all bytes
    Waiter(TrafficMemory& memory, const Holder& holder,
           std::function<bool(std::uint64_t taken)> could_go_on);
    ~Waiter();
    Waiter(const Waiter&) = delete;
    Waiter& operator=(const Waiter&) = delete;
    /// Whether this waiter has to give up, since no holder can go on. All holders wait for each
    /// other and not for memory that belongs to no request and is freed by itself. Or all have
    /// waited for such memory for long. One waiter at a time gives up; the next one only after the
    /// first has given its memory back.
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
  /// Whether a request without memory may begin with so many bytes. While other holders wait for
  /// more, it may only where at most half is taken.
  bool lets_begin(const Holder& holder, std::uint64_t bytes) const;
  /// Precondition: has_room.
  void add(Holder* holder, std::uint64_t bytes);
  void subtract(Holder* holder, std::uint64_t bytes);

  const std::uint64_t all_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< something was given back
  std::uint64_t taken_ = 0;
  std::uint64_t nobodys_ = 0;  ///< of that, what belongs to no request
  const Holder* large_ =
      nullptr;  ///< the holder beyond the limit; null whenever the sum is within `all_`
  std::size_t holders_ = 0;         ///< that have something
  std::vector<Waiter*> waiters_{};  ///< of the holders that wait for more
};

}  // namespace sightline
