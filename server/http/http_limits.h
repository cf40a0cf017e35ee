#pragma once
/// Limits of the event loop: connections, headers, bodies, memory and times.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/live.h"
#include "server/http/pace.h"
#include "server/http/request_head.h"

namespace sightline {

/// Each is a flag, and shown by /version; those that are Live may change while it serves.
struct HttpLimits {
  /// Workers for short requests, as many for bulk ones, and a quarter as many for long ones.
  std::size_t workers = 32;
  std::size_t queue = 512;    ///< requests that wait for a worker of either kind; more are 503
  std::size_t streams = 128;  ///< open at once, each on a thread of its own; more are 503
  /// Beyond it those that have been idle the longest are closed.
  Live<std::size_t> connections{10'000};
  HeadLimits head{};
  /// From the first byte of a head to its last.
  LiveTime head_time{std::chrono::milliseconds(10'000)};
  /// How long a connection may wait for a request.
  LiveTime idle{std::chrono::milliseconds(30'000)};
  PaceLimits pace{};  ///< of bodies and answers
  /// Least bytes per second of a large body or answer while others need its room in the spool, and
  /// of a stream while others need its memory.
  Live<std::uint64_t> busy_rate{1 << 20};
  /// Temporary files of bodies and answers: their folder, and the bytes of all of them.
  std::string spool_folder = "/tmp";
  std::uint64_t spool_bytes = std::uint64_t{16} << 30;
  /// Bytes of memory of connections and requests. One request at a time may exceed it.
  /// `serve` sets an eighth of the machine's memory, at least 256 MiB.
  std::uint64_t memory = 64 << 20;
  /// Bytes that one request may take.
  std::uint64_t request = std::uint64_t{4} << 30;

  void take_live(const HttpLimits& other) {
    connections = other.connections;
    head = other.head;
    head_time = other.head_time;
    idle = other.idle;
    pace = other.pace;
    busy_rate = other.busy_rate;
  }
};

}  // namespace sightline
