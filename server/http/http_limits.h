#pragma once
/// HttpLimits: limits of connections, headers, bodies, memory and times.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/live.h"
#include "server/http/pace.h"
#include "server/http/request_head.h"

namespace sightline {

/// Each limit is a flag, and /version shows it. Those that are Live may change while the server
/// runs.
struct HttpLimits {
  /// Workers for short requests. There are as many for bulk requests, and a quarter as many for
  /// long ones.
  std::size_t workers = 32;
  /// requests that wait for a worker of one kind; further ones are answered with 503
  std::size_t queue = 512;
  /// open streams, each on a thread of its own; further ones are answered with 503
  std::size_t streams = 128;
  /// Open connections. Beyond this number, the connections that have been idle longest are closed.
  Live<std::size_t> connections{10'000};
  HeadLimits head{};
  /// Longest time from the first byte of a head to its last.
  LiveTime head_time{std::chrono::milliseconds(10'000)};
  /// Longest time that a connection may wait for a request.
  LiveTime idle{std::chrono::milliseconds(30'000)};
  PaceLimits pace{};  ///< of bodies and answers
  /// Least bytes per second of a large body or answer while others need its room in the spool, and
  /// of a stream while others need its memory.
  Live<std::uint64_t> busy_rate{1 << 20};
  /// The spool, temporary files of bodies and answers: their folder, and the bytes of all files.
  std::string spool_folder = "/tmp";
  std::uint64_t spool_bytes = std::uint64_t{16} << 30;
  /// Bytes of memory for connections and requests. One request at a time may exceed it. `serve`
  /// sets an eighth of the machine's memory, at least 256 MiB.
  std::uint64_t memory = 64 << 20;
  /// Bytes of memory that one request may use.
  std::uint64_t request = std::uint64_t{4} << 30;

  /// Takes the values that are Live.
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

// Tests: tests/integration/settings_test.py
