#pragma once
/// Flags of the event loop: connections, headers, rates and queues.

#include <cstdint>

#include "server/http/door_limits.h"

namespace CLI {
class App;
}

namespace sightline {

/// Seconds as they are written; what becomes of them is DoorLimits.
struct DoorSeconds {
  double idle = 30, head = 10, window = 5, longest = 600;
};

/// Bytes as they are written. 0: not given, and derived from the memory for requests, or that from
/// the memory of the machine.
struct DoorBytes {
  std::uint64_t memory = 0, buffers = 0, bodies = 0, work = 0;
};

void define_door(CLI::App& app, DoorLimits& limits, DoorSeconds& seconds, DoorBytes& bytes);
/// After the parse. machine  bytes of memory that the machine has
void finish_door(DoorLimits& limits, const DoorSeconds& seconds, const DoorBytes& bytes,
                 std::uint64_t machine);

}  // namespace sightline
