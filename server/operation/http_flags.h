#pragma once
/// The flags of the event loop: connections, headers, rates and queues.

#include "server/http/http_limits.h"

namespace CLI {
class App;
}

namespace sightline {

/// Values of flags in seconds, which finish_http_flags converts to HttpLimits.
struct HttpSeconds {
  double idle = 30, head = 10, window = 5, longest = 600;
};

/// Adds the flags to `app`; parsing sets `limits` and `seconds`, which must outlive `app`.
void define_http_flags(CLI::App& app, HttpLimits& limits, HttpSeconds& seconds);
/// Converts `seconds` into `limits`. To be called after parsing.
void finish_http_flags(HttpLimits& limits, const HttpSeconds& seconds);

}  // namespace sightline
