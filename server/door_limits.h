#pragma once
/// What the door lets in, and for how long.

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "server/pace.h"
#include "server/request_head.h"

namespace sightline {

/// Each is a flag, and shown by /version.
struct DoorLimits {
  /// Requests answered at once; and again as many whose bodies are long, chunked, or waited for.
  std::size_t workers = 32;
  std::size_t queue = 512;  ///< requests that wait for a worker of either kind; more are 503
  std::size_t connections = 10'000;  ///< beyond it those that have been idle the longest are closed
  HeadLimits head{};
  std::chrono::milliseconds head_time{10'000};  ///< from the first byte of a head to its last
  std::chrono::milliseconds idle{30'000};       ///< how long a connection may wait for a request
  PaceLimits pace{};                            ///< of bodies and answers
  std::uint64_t gathered = 64 << 10;  ///< bytes of a body that comes in before a worker is taken
  /// Bytes of gathered bodies and of answers that clients have not taken, together.
  std::uint64_t buffers = 32 << 20;
  std::uint64_t bodies = 32 << 20;  ///< bytes of longer bodies of queries, together
  std::uint64_t work = 24 << 20;    ///< bytes that answering those may take, together
};

}  // namespace sightline
