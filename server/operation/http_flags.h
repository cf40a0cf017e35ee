#pragma once
/// Flags of the event loop: connections, headers, rates and queues.

#include "server/http/http_limits.h"

namespace CLI {
class App;
}

namespace sightline {

/// Seconds as they are written; what becomes of them is HttpLimits.
struct HttpSeconds {
  double idle = 30, head = 10, window = 5, longest = 600;
};

void define_http_flags(CLI::App& app, HttpLimits& limits, HttpSeconds& seconds);
/// After the parse.
void finish_http_flags(HttpLimits& limits, const HttpSeconds& seconds);

}  // namespace sightline
