#pragma once
/// The memory of connections: long headers, bodies that come, answers that wait.

#include <atomic>
#include <cstdint>

#include "server/http/traffic_memory.h"

namespace sightline {

/// The bytes that all connections may hold. They count in the memory for requests too. May be
/// used from many threads.
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

}  // namespace sightline
