#pragma once
/// Flags of the HTTP server: workers, queues, connections, headers, spool, memory, rates and times.

#include "server/http/http_limits.h"

namespace CLI {
class App;
}

namespace sightline {

/// Values of flags in seconds, which finish_http_flags converts to HttpLimits.
struct HttpSeconds {
  double idle = 30;      ///< --idle-seconds
  double head = 10;      ///< --header-seconds
  double window = 5;     ///< --rate-seconds
  double longest = 600;  ///< --body-seconds
};

/// Adds the flags to `app`; parsing sets `limits` and `seconds`, which must outlive `app`.
void define_http_flags(CLI::App& app, HttpLimits& limits, HttpSeconds& seconds);
/// Converts `seconds` into `limits`. To be called after parsing.
void finish_http_flags(HttpLimits& limits, const HttpSeconds& seconds);

}  // namespace sightline

// Tests: tests/integration/settings_test.py
