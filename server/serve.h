#pragma once
/// sightline serve: makes all parts of a server and connects them.

#include <functional>
#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Ends the process with an exit code, whatever its threads are doing.
using EndNow = std::function<void(int code)>;

/// Serves until SIGTERM or SIGINT, which drains running requests; a second signal aborts them. A
/// signal during the final teardown ends the process at once by its default action, or by `end_now`
/// where a signal cannot (in a container). The first line on `out` is "listening on
/// http://ADDR:PORT", as soon as connections are accepted. Errors of the start go to `complaints`,
/// the log goes to standard error. Returns the exit code: 0 after a stop, 2 if it could not start.
/// Must be called from the first thread, before any other thread is started.
int run_serve(const ServeCommand& command, const EndNow& end_now, std::ostream& out,
              std::ostream& complaints);

}  // namespace sightline

// Tests: tests/integration/settings_test.py
