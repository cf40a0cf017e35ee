#pragma once
/// sightline serve: makes all parts of a server and connects them.

#include <functional>
#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Ends the process with that exit code, whatever else is going on in it.
using EndNow = std::function<void(int code)>;

/// Serves until SIGTERM or SIGINT, which drains running requests. A second signal aborts them. A
/// signal during the final teardown ends the process at once, as that signal does; `end_now` does
/// it where no signal can (in a container). The first line on `out` is "listening on
/// http://ADDR:PORT", as soon as connections are accepted. The log goes to standard error. Returns
/// the exit code: 0 after a stop, 2 when it could not start. Call from the first thread, before any
/// other is made.
int run_serve(const ServeCommand& command, const EndNow& end_now, std::ostream& out,
              std::ostream& complaints);

}  // namespace sightline
