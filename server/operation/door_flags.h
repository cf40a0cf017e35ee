#pragma once
/// Flags of the event loop: connections, headers, rates and queues.

#include "server/http/door_limits.h"

namespace CLI {
class App;
}

namespace sightline {

/// Seconds as they are written; what becomes of them is DoorLimits.
struct DoorSeconds {
  double idle = 30, head = 10, window = 5, longest = 600;
};

void define_door(CLI::App& app, DoorLimits& limits, DoorSeconds& seconds);
/// After the parse.
void finish_door(DoorLimits& limits, const DoorSeconds& seconds);

}  // namespace sightline
