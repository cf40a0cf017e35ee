#pragma once
/// Memory that large requests share: who does not fit waits, or is told to come again.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "core/base/deadline.h"

namespace sightline {

/// A number of bytes, counted and not allocated. Who is alone may take any number, so that nothing
/// is too large for ever. Outlives its shares; may be used from many threads.
class WorkMemory {
 public:
  explicit WorkMemory(std::uint64_t bytes) : limit_(bytes) {}

  class Share {
   public:
    explicit Share(WorkMemory& memory) : memory_(memory) {}
    ~Share();
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    /// Adds to the share. False, and nothing added, when it does not fit now.
    bool grow(std::uint64_t bytes);
    /// The same, but waits for its turn until the deadline.
    bool wait(std::uint64_t bytes, const Deadline& deadline);

   private:
    WorkMemory& memory_;
    std::uint64_t bytes_ = 0;
  };

 private:
  bool fits(std::uint64_t bytes, std::uint64_t own) const {
    return taken_ == own || taken_ + bytes <= limit_;
  }

  const std::uint64_t limit_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t taken_ = 0;
};

/// What one request has of it.
struct RequestMemory {
  WorkMemory::Share body;  ///< the bytes of its body, as they come
  WorkMemory::Share work;  ///< what it takes to decode, answer and encode it
  std::chrono::milliseconds patience;
};

}  // namespace sightline
